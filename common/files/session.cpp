// SPDX-License-Identifier: Apache-2.0
// session.json: written whole, read with every value checked.
#include "common/files/session.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/json_table.h"
#include "common/files/text.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array<std::string_view, 3> kRoleNames{"black", "spectralon", "skin"};
constexpr const char* kFormat = "dermap session";
constexpr int kFormatVersion = 1;

// A path inside the config directory is written relative to it: the manifest says nothing about the machine.
std::string PortablePath(const fs::path& path) {
  if (path.is_relative()) return path.generic_string();
  try {
    const fs::path relative = path.lexically_relative(fs::absolute(ConfigDirectory()).lexically_normal());
    if (!relative.empty() && *relative.begin() != "..") return relative.generic_string();
  } catch (const InputError&) {  // no config directory: the path stays as it is
  }
  return path.generic_string();
}

json RigToJson(const RigConfig& rig) {
  json slots = json::array();
  for (const WheelSlot& slot : rig.slots) {
    if (slot.opaque) {
      slots.push_back({{"slot", slot.slot}, {"opaque", true}});
    } else {
      slots.push_back(
          {{"slot", slot.slot}, {"wavelength_nm", slot.wavelength_nm}, {"fwhm_nm", slot.fwhm_nm}});
    }
  }
  json result{
      {"name", rig.name},
      {"camera", {{"driver", rig.camera_driver}, {"port", rig.camera_port}, {"model", rig.camera_model}}},
      {"wheel", {{"driver", rig.wheel_driver}, {"serial", rig.wheel_serial}, {"slot", slots}}},
      {"flash", {{"recycle_s", rig.flash_recycle_s}}},
      {"geometry", {{"window_mm", rig.window_mm}, {"view_angle_deg", rig.view_angle_deg}}},
      {"references",
       {{"spectralon_csv", PortablePath(rig.spectralon_csv)},
        {"gray_card_reflectance", rig.gray_card_reflectance},
        {"gray_card_region", rig.gray_card_region}}}};
  if (rig.light_angle_deg != 0.0) result["geometry"]["light_angle_deg"] = rig.light_angle_deg;
  RigOptics optics = rig.optics;
  for (fs::path* csv : {&optics.camera_csv, &optics.flash_csv}) *csv = PortablePath(*csv);
  AddRigOptics(optics, result);
  if (!rig.simulated_scene.empty()) result["simulated"] = {{"scene", PortablePath(rig.simulated_scene)}};
  return result;
}

json PlanToJson(const PlanConfig& plan) {
  json exposures = json::array();
  for (const PlannedExposure& exposure : plan.exposures) {
    exposures.push_back(
        {{"slot", exposure.slot}, {"exposure_ms", exposure.exposure_ms}, {"iso", exposure.iso}});
  }
  return {{"subject", plan.subject},
          {"site", plan.site},
          {"notes", plan.notes},
          {"black_frames", plan.black_frames},
          {"spectralon_frames", plan.spectralon_frames},
          {"skin_frames", plan.skin_frames},
          {"adapt_exposure", plan.adapt_exposure},
          {"exposure", exposures}};
}

// A name inside the session folder: relative, and never through "..".
void CheckFrameFile(const std::string& file, const std::string& where) {
  const fs::path path(file);
  const bool leaves = path.is_absolute() || std::find(path.begin(), path.end(), fs::path("..")) != path.end();
  if (file.empty() || leaves || !path.has_filename()) {
    throw InputError(where + ": 'file' is \"" + Shorten(file, 80) +
                     "\"; expected a path inside the session folder, such as frames/0001_black_0nm.dng");
  }
}

void CheckSha256(const std::string& sha256, const std::string& where) {
  if (sha256.size() != 64 || sha256.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw InputError(where + ": 'sha256' is \"" + Shorten(sha256, 70) + "\"; expected 64 hexadecimal digits");
  }
}

FrameRole ReadRole(TomlTable& table, const std::string& where) {
  const std::string role = table.RequiredString("role");
  if (const auto known = RoleFromName(role)) return *known;
  throw InputError(where + ": 'role' is \"" + Shorten(role, 40) + "\"; expected " + Join(kRoleNames, ", "));
}

// Unknown keys pass: a later version may record more about a frame.
FrameRecord ReadFrame(TomlTable& table, const std::string& where) {
  FrameRecord frame;
  frame.number = table.RequiredInteger("number", 1, 9999999);
  frame.role = ReadRole(table, where);
  frame.slot = table.RequiredInteger("slot", 1, 64);
  if (frame.role != FrameRole::kBlack) {
    frame.wavelength_nm = table.RequiredNumber("wavelength_nm", kShortestWavelengthNm, kLongestWavelengthNm);
    frame.fwhm_nm = table.RequiredNumber("fwhm_nm", 0.0, 200.0);
  }
  frame.exposure_ms = table.RequiredNumber("exposure_ms", 0.01, 600000.0);
  frame.iso = table.RequiredInteger("iso", 25, 409600);
  frame.file = table.RequiredString("file");
  CheckFrameFile(frame.file, where);
  frame.sha256 = table.RequiredString("sha256");
  CheckSha256(frame.sha256, where);
  frame.time_utc = table.String("time_utc", "");
  frame.polarizer = table.String("polarizer", "");
  if (frame.polarizer != "" && frame.polarizer != "s" && frame.polarizer != "p") {
    throw InputError(where + ": 'polarizer' is \"" + Shorten(frame.polarizer, 20) +
                     "\"; expected s or p, the position of the camera's polarizer");
  }
  return frame;
}

ExposureChange ReadChange(TomlTable& table, const std::string& where) {
  ExposureChange change;
  change.role = ReadRole(table, where);
  change.slot = table.RequiredInteger("slot", 1, 64);
  change.from_iso = table.RequiredInteger("from_iso", 25, 409600);
  change.to_iso = table.RequiredInteger("to_iso", 25, 409600);
  change.number = table.RequiredInteger("number", 1, 9999999);
  change.why = table.String("why", "");
  change.time_utc = table.String("time_utc", "");
  return change;
}

void ReadFrames(TomlTable& manifest, const std::string& file, Session& session) {
  std::set<int> numbers;
  std::set<std::string> files;
  for (TomlTable& table : manifest.Tables("frames")) {
    const std::string where = file + ": frame " + std::to_string(session.frames.size() + 1) + " of the list";
    FrameRecord frame = ReadFrame(table, where);
    if (!numbers.insert(frame.number).second) {
      throw InputError(where + ": the number " + std::to_string(frame.number) +
                       " is given twice; expected each frame once");
    }
    if (!files.insert(fs::path(frame.file).lexically_normal().generic_string()).second) {
      throw InputError(where + ": the file " + frame.file + " is given twice; expected each frame once");
    }
    session.frames.push_back(std::move(frame));
  }
  std::sort(session.frames.begin(), session.frames.end(),
            [](const auto& a, const auto& b) { return a.number < b.number; });
}

void CheckFormat(TomlTable& manifest, const std::string& file) {
  const std::string format = manifest.RequiredString("format");
  const int version = manifest.RequiredInteger("format_version", 1, 1000000);
  if (format != kFormat || version != kFormatVersion) {
    throw InputError(file + ": format '" + Shorten(format, 40) + "' version " + std::to_string(version) +
                     "; expected '" + kFormat + "' version " + std::to_string(kFormatVersion));
  }
}

TomlTable RequireTable(TomlTable& manifest, const std::string& key, const std::string& file) {
  auto table = manifest.Table(key);
  if (!table)
    throw InputError(file + ": the object '" + key + "' is missing; remedy: restore it from a copy");
  return std::move(*table);
}

}  // namespace

std::string_view RoleName(FrameRole role) {
  return kRoleNames[static_cast<std::size_t>(role)];
}

std::optional<FrameRole> RoleFromName(std::string_view name) {
  const auto found = std::find(kRoleNames.begin(), kRoleNames.end(), name);
  if (found == kRoleNames.end()) return std::nullopt;
  return static_cast<FrameRole>(found - kRoleNames.begin());
}

json FrameToJson(const FrameRecord& frame) {
  json result{{"number", frame.number}, {"role", RoleName(frame.role)},
              {"slot", frame.slot},     {"exposure_ms", frame.exposure_ms},
              {"iso", frame.iso},       {"file", frame.file},
              {"sha256", frame.sha256}, {"time_utc", frame.time_utc}};
  if (frame.role != FrameRole::kBlack) {
    result["wavelength_nm"] = frame.wavelength_nm;
    result["fwhm_nm"] = frame.fwhm_nm;
  }
  if (!frame.polarizer.empty()) result["polarizer"] = frame.polarizer;
  return result;
}

FrameRecord FrameFromJson(const json& object, const std::string& where) {
  TomlTable table = ToTable(object, where);
  return ReadFrame(table, where);
}

json ExposureChangeToJson(const ExposureChange& change) {
  return {{"role", RoleName(change.role)}, {"slot", change.slot},     {"from_iso", change.from_iso},
          {"to_iso", change.to_iso},       {"number", change.number}, {"why", change.why},
          {"time_utc", change.time_utc}};
}

ExposureChange ExposureChangeFromJson(const json& object, const std::string& where) {
  TomlTable table = ToTable(object, where);
  return ReadChange(table, where);
}

Session ReadSession(const fs::path& directory) {
  const fs::path path = directory / "session.json";
  std::error_code ignored;
  if (!fs::is_directory(directory, ignored)) {
    throw InputError("cannot read the session " + directory.string() +
                     ": it is not a folder; remedy: name the folder that holds session.json");
  }
  const std::string file = path.string();
  TomlTable manifest = ReadJsonTable(path);
  CheckFormat(manifest, file);
  Session session;
  session.directory = directory;
  session.dermap_version = manifest.String("dermap_version", "");
  session.started_utc = manifest.String("started_utc", "");
  session.complete = manifest.Boolean("complete", false);
  TomlTable rig = RequireTable(manifest, "rig", file);
  session.rig = ReadRigTable(rig);
  TomlTable plan = RequireTable(manifest, "plan", file);
  session.plan = ReadPlanTable(plan);
  ReadFrames(manifest, file, session);
  for (TomlTable& table : manifest.Tables("exposure_changes")) {
    session.exposure_changes.push_back(ReadChange(table, file + ": a change of exposure"));
  }
  return session;
}

void WriteSession(const Session& session) {
  json frames = json::array();
  for (const FrameRecord& frame : session.frames) frames.push_back(FrameToJson(frame));
  json changes = json::array();
  for (const ExposureChange& change : session.exposure_changes)
    changes.push_back(ExposureChangeToJson(change));
  const json manifest{{"format", kFormat},
                      {"format_version", kFormatVersion},
                      {"dermap_version", session.dermap_version},
                      {"started_utc", session.started_utc},
                      {"complete", session.complete},
                      {"rig", RigToJson(session.rig)},
                      {"plan", PlanToJson(session.plan)},
                      {"exposure_changes", changes},
                      {"frames", frames}};
  WriteFileAtomically(session.directory / "session.json",
                      manifest.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

void VerifyFrames(const Session& session) {
  for (const FrameRecord& frame : session.frames) {
    const fs::path path = session.directory / frame.file;
    const std::string found = Sha256OfFile(path);
    if (found == frame.sha256) continue;
    throw InputError(path.string() + " is not the file that was captured (SHA-256 " + found.substr(0, 12) +
                     "..., the manifest says " + frame.sha256.substr(0, 12) +
                     "...); remedy: restore it from a copy or capture the session again");
  }
}

std::string FrameFileName(const FrameRecord& frame, const std::string& extension) {
  const std::string dot = extension.starts_with(".") ? "" : ".";
  return fmt::format("frames/{:04}_{}_{}nm{}{}", frame.number, RoleName(frame.role),
                     FormatNumber(frame.wavelength_nm), dot, extension);
}

}  // namespace dermap
