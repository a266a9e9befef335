// SPDX-License-Identifier: Apache-2.0
// FILES.toml to a session that exists nowhere but in memory.
#include "calibrate/folder_session.h"

#include <algorithm>
#include <set>

#include "calibrate/raw_frame.h"
#include "common/core/error.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

// The rig's file where one is named, and what the TOML says beside it.
RigConfig ReadFolderRig(TomlTable& file, const fs::path& folder) {
  RigConfig rig;
  const std::string rig_path = file.String("rig", "");
  if (!rig_path.empty()) {
    rig = ReadRig(folder / rig_path);
  } else {
    rig.name = folder.filename().string();
    rig.optics = ReadRigOptics(file);
  }
  rig.window_mm = file.Number("window_mm", rig.window_mm, 0.5, 100.0);
  rig.view_angle_deg = file.Number("view_angle_deg", rig.view_angle_deg, 0.0, 80.0);
  rig.light_angle_deg = file.Number("light_angle_deg", rig.light_angle_deg, 0.0, 80.0);
  const std::string csv = file.String("spectralon_csv", "");
  if (!csv.empty())
    rig.spectralon_csv = fs::exists(folder / csv) ? fs::absolute(folder / csv) : fs::path(csv);
  const auto region =
      file.Numbers("gray_card_region", {rig.gray_card_region.begin(), rig.gray_card_region.end()});
  if (region.size() != 4) {
    throw InputError(file.Where("gray_card_region") + ": 'gray_card_region' holds " +
                     std::to_string(region.size()) +
                     " numbers; expected x, y, width, height as shares of the frame");
  }
  std::copy(region.begin(), region.end(), rig.gray_card_region.begin());
  return rig;
}

// `unreadable` takes what is wrong with the file, where its header was to be asked.
FrameRecord ReadFolderFrame(TomlTable& table, const fs::path& folder, std::string& unreadable) {
  FrameRecord frame;
  frame.file = table.RequiredString("file");
  const std::string role = table.RequiredString("role");
  const auto known = RoleFromName(role);
  if (!known) {
    throw InputError(table.Where("role") + ": 'role' is \"" + role +
                     "\"; expected black, spectralon or skin");
  }
  frame.role = *known;
  if (frame.role != FrameRole::kBlack) {
    frame.wavelength_nm = table.RequiredNumber("wavelength_nm", kShortestWavelengthNm, kLongestWavelengthNm);
    frame.fwhm_nm = table.Number("fwhm_nm", 10.0, 0.0, 200.0);
  }
  frame.exposure_ms = table.Number("exposure_ms", 0.0, 0.0, 600000.0);
  frame.iso = table.Integer("iso", 0, 0, 409600);
  frame.polarizer = table.String("polarizer", "");
  if (frame.polarizer != "" && frame.polarizer != "s" && frame.polarizer != "p")
    throw InputError(table.Where("polarizer") + ": 'polarizer' is \"" + frame.polarizer +
                     "\"; expected s or p");
  if (frame.exposure_ms == 0.0 || frame.iso == 0) {
    RawExposure found;
    try {
      found = ReadRawExposure(folder / frame.file);
    } catch (const InputError& error) {
      if (unreadable.empty()) unreadable = error.what();
      table.Finish();
      return frame;
    }
    if (frame.exposure_ms == 0.0) frame.exposure_ms = found.exposure_ms;
    if (frame.iso == 0) frame.iso = found.iso;
  }
  if (!(frame.exposure_ms > 0.0) || frame.iso <= 0) {
    throw InputError(table.Where("file") + ": " + frame.file +
                     " does not say its exposure or ISO; remedy: add exposure_ms and iso beside its name");
  }
  table.Finish();
  return frame;
}

// Filters count from 1 in order of wavelength.
void NumberSlots(Session& session) {
  std::set<std::pair<double, double>> filters;
  for (const FrameRecord& frame : session.frames) {
    if (frame.role != FrameRole::kBlack) filters.insert({frame.wavelength_nm, frame.fwhm_nm});
  }
  if (session.rig.slots.empty()) {
    for (const auto& [nm, fwhm] : filters)
      session.rig.slots.push_back({static_cast<int>(session.rig.slots.size()) + 1, nm, fwhm, false});
  }
}

}  // namespace

Session ReadFolderSession(const fs::path& files_toml) {
  TomlTable file = TomlTable::ReadFile(files_toml);
  const fs::path folder = files_toml.has_parent_path() ? files_toml.parent_path() : fs::path(".");
  Session session;
  session.directory = folder;
  session.rig = ReadFolderRig(file, folder);
  session.complete = true;
  std::string unreadable;
  for (TomlTable& table : file.Tables("frame")) {
    session.frames.push_back(ReadFolderFrame(table, folder, unreadable));
    session.frames.back().number = static_cast<int>(session.frames.size());
  }
  if (session.frames.empty()) {
    throw InputError(
        file.Where() +
        ": no frames; remedy: add a [[frame]] with file, role and wavelength_nm for every raw file");
  }
  file.Finish();
  NumberSlots(session);
  if (!unreadable.empty()) throw UnreadableFrame(unreadable, std::move(session));
  return session;
}

}  // namespace dermap
