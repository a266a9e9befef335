// SPDX-License-Identifier: Apache-2.0
// The session folder: session.json (manifest), journal.jsonl (append-only) and frames/ (untouched camera files).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/files/rig.h"

namespace dermap {

enum class FrameRole { kBlack, kSpectralon, kSkin };
std::string_view RoleName(FrameRole role);  // "black", "spectralon", "skin"

struct FrameRecord {
  int number = 0;  // counts from 1 in order of exposure
  FrameRole role = FrameRole::kBlack;
  int slot = 0;  // of the wheel, counts from 1; the slot that the light passed (the opaque one for black frames)
  double wavelength_nm = 0.0;  // 0 for black frames
  double fwhm_nm = 0.0;
  double exposure_ms = 0.0;
  int iso = 0;
  std::string file;  // relative to the session folder: frames/NNNN_role_wavelength.dng
  std::string sha256;
  std::string time_utc;  // ISO 8601
};

struct Session {
  std::filesystem::path directory;
  std::string dermap_version;
  std::string started_utc;
  RigConfig rig;
  PlanConfig plan;
  bool complete = false;
  std::vector<FrameRecord> frames;
};

// Reads and validates session.json; throws InputError that names what is wrong (a relative file that leaves the folder,
// a role that does not exist, ...). Does not read the frames; VerifyFrames does.
Session ReadSession(const std::filesystem::path& directory);
void WriteSession(const Session& session);

// Throws InputError naming the first frame that is missing or whose SHA-256 differs.
void VerifyFrames(const Session& session);

}  // namespace dermap
