// SPDX-License-Identifier: Apache-2.0
// The session folder: session.json (manifest), journal.jsonl (append-only) and frames/ (untouched camera
// files).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/files/rig.h"

namespace dermap {

enum class FrameRole { kBlack, kSpectralon, kSkin };
std::string_view RoleName(FrameRole role);  // "black", "spectralon", "skin"
std::optional<FrameRole> RoleFromName(std::string_view name);

struct FrameRecord {
  int number = 0;  // counts from 1 in order of exposure
  FrameRole role = FrameRole::kBlack;
  int slot =
      0;  // of the wheel, counts from 1; the slot that the light passed (the opaque one for black frames)
  double wavelength_nm = 0.0;  // 0 for black frames
  double fwhm_nm = 0.0;
  double exposure_ms = 0.0;
  int iso = 0;
  std::string file;         // relative to the session folder: frames/NNNN_role_wavelength.dng
  std::string sha256;       // 64 hexadecimal digits, lower case
  std::string time_utc;     // ISO 8601
  std::string polarizer{};  // of the camera: "s", "p", or empty where a session has one position only
};

// A filter's ISO that was changed while the session was taken, because a frame showed that the plan's did not
// suit: of Spectralon and skin (role spectralon), or of skin alone (role skin).
struct ExposureChange {
  FrameRole role = FrameRole::kSpectralon;
  int slot = 0;
  int from_iso = 0;
  int to_iso = 0;
  int number = 0;  // of the frame that showed it
  std::string why;
  std::string time_utc;  // ISO 8601
};

struct Session {
  std::filesystem::path directory;
  std::string dermap_version;
  std::string started_utc;  // ISO 8601
  RigConfig rig;
  PlanConfig plan;
  bool complete = false;
  std::vector<FrameRecord> frames;                 // ascending number
  std::vector<ExposureChange> exposure_changes{};  // in the order in which they were made
};

// Reads and validates session.json; throws InputError that names what is wrong (a relative file that leaves
// the folder, a role that does not exist, ...). Does not read the frames; VerifyFrames does.
Session ReadSession(const std::filesystem::path& directory);
void WriteSession(const Session& session);

// A frame as in session.json's list; the journal's lines hold it too. Both check every value (InputError;
// `where` begins the sentence).
nlohmann::json FrameToJson(const FrameRecord& frame);
FrameRecord FrameFromJson(const nlohmann::json& json, const std::string& where);
// The same for a change of exposure.
nlohmann::json ExposureChangeToJson(const ExposureChange& change);
ExposureChange ExposureChangeFromJson(const nlohmann::json& json, const std::string& where);

// Throws InputError naming the first frame that is missing or whose SHA-256 differs.
void VerifyFrames(const Session& session);

// "frames/0007_skin_450nm.dng": where a frame belongs.
std::string FrameFileName(const FrameRecord& frame, const std::string& extension);

}  // namespace dermap
