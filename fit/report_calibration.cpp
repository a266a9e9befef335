// SPDX-License-Identifier: Apache-2.0
// Reads the calibration sidecar with patience: what is missing or odd is left out or said in words.
#include "fit/report_calibration.h"

#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/picture.h"
#include "fit/report_parts.h"

namespace dermap {
namespace {

using nlohmann::json;

// Numbers short, arrays with commas, everything else as JSON writes it.
std::string ForPeople(const json& value) {
  if (value.is_null()) return {};
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number()) return FormatValue(value.get<double>());
  if (!value.is_array()) return value.dump(-1, ' ', false, json::error_handler_t::replace);
  std::string text;
  for (const json& item : value) {
    if (!text.empty()) text += item.is_string() ? "; " : ", ";
    text += ForPeople(item);
  }
  return text;
}

std::string TextOf(const json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? std::string{} : ForPeople(*found);
}

std::string ShareOf(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return TextOf(object, key);
  return Percent(found->get<double>(), 3);
}

CalibrationStep ReadStep(const json& step) {
  CalibrationStep result{TextOf(step, "step"), {}};
  const std::string note = TextOf(step, "note");
  const auto applied = step.find("applied");
  if (applied == step.end() || !applied->is_boolean() || !applied->get<bool>()) {
    result.change = "no: " + note;
    return result;
  }
  result.change = ShareOf(step, "effect") + " \u00b1 " + ShareOf(step, "sigma");
  if (!note.empty()) result.change += " (" + note + ")";
  return result;
}

CalibratedBand ReadBand(const json& band) {
  CalibratedBand result;
  result.wavelength_nm = TextOf(band, "wavelength_nm");
  result.frame = TextOf(band, "frame");
  result.gray_card_drift = TextOf(band, "gray_card_drift");
  result.alignment_shift_px = TextOf(band, "alignment_shift_px");
  result.median_noise = TextOf(band, "median_noise");
  result.saturated_share = ShareOf(band, "saturated_share");
  result.notes = TextOf(band, "notes");
  result.systematic_sigma = ShareOf(band, "systematic_sigma");
  if (band.contains("steps") && band["steps"].is_array()) {
    for (const json& step : band["steps"]) {
      if (step.is_object()) result.steps.push_back(ReadStep(step));
    }
  }
  return result;
}

// Only files within the sidecar's folder: a record from elsewhere must not pull other files into the page.
CalibrationPicture ReadPicture(const json& entry, const std::filesystem::path& folder) {
  CalibrationPicture picture;
  picture.title = TextOf(entry, "title");
  const std::filesystem::path file = TextOf(entry, "file");
  if (picture.title.empty()) picture.title = file.filename().string();
  const auto inside = file.lexically_normal();
  if (file.empty() || inside.is_absolute() || *inside.begin() == "..") {
    picture.problem = "The record names a file outside its folder: " + file.string();
    return picture;
  }
  try {
    picture.data_uri = PictureDataUri(folder / inside);
  } catch (const InputError& error) {
    picture.problem = error.what();
  }
  return picture;
}

void Fill(CalibrationRecord& record, const json& root, const std::filesystem::path& folder) {
  record.session = TextOf(root, "session");
  const auto correlation = root.find("correlation");
  if (correlation != root.end()) {  // numbers with a note for people, or a sentence
    record.correlation = correlation->is_object() ? TextOf(*correlation, "note") : ForPeople(*correlation);
  }
  record.notes = TextOf(root, "notes");
  if (root.contains("bands") && root["bands"].is_array()) {
    for (const json& band : root["bands"]) {
      if (band.is_object()) record.bands.push_back(ReadBand(band));
    }
  }
  if (root.contains("pictures") && root["pictures"].is_array()) {
    for (const json& entry : root["pictures"]) {
      if (entry.is_object()) record.pictures.push_back(ReadPicture(entry, folder));
    }
  }
}

}  // namespace

CalibrationRecord ReadCalibrationRecord(const std::filesystem::path& path) {
  CalibrationRecord record;
  try {
    const json root = json::parse(ReadTextFile(path));
    if (root.is_object()) {
      Fill(record, root, path.parent_path());
    } else {
      record.problem = path.filename().string() + " holds no JSON object.";
    }
  } catch (const InputError& error) {
    record.problem = error.what();
  } catch (const json::exception& error) {
    record.problem = path.filename().string() + " is not valid JSON: " + error.what();
  }
  return record;
}

std::string PictureDataUri(const std::filesystem::path& path) {
  const auto bytes = ReadBinaryFile(path);
  const auto starts_with = [&](std::initializer_list<int> magic) {
    std::size_t i = 0;
    for (const int byte : magic) {
      if (i >= bytes.size() || std::to_integer<int>(bytes[i++]) != byte) return false;
    }
    return true;
  };
  if (starts_with({0x89, 'P', 'N', 'G'})) return DataUri(bytes, "image/png");
  if (starts_with({0xff, 0xd8, 0xff})) return DataUri(bytes, "image/jpeg");
  throw InputError(path.string() + " is neither PNG nor JPEG; only these can be put into a report.");
}

}  // namespace dermap
