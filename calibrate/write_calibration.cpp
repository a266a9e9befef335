// SPDX-License-Identifier: Apache-2.0
// The record of a calibration as JSON and pictures.
#include "calibrate/write_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "calibrate/frame_picture.h"
#include "common/files/atomic_file.h"
#include "common/files/picture.h"

namespace dermap {
namespace {

using nlohmann::json;

// 450 -> "450nm", 532.5 -> "532.5nm"
std::string NameOf(double wavelength_nm) {
  char text[32];
  std::snprintf(text, sizeof text, "%gnm", wavelength_nm);
  return text;
}

json NumberOrNull(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json RecordOfWindow(const Window& window) {
  json corners = json::array();
  for (const Point& p : window.corners) corners.push_back({p.x, p.y});
  return {{"corners_px", corners}, {"edge_uncertainty_px", window.edge_uncertainty_px}};
}

json RecordOfCorrelation(const NoiseCorrelation& c) {
  return {{"along_x", c.along_x}, {"along_y", c.along_y}, {"diagonal", c.diagonal}};
}

json RecordOfSteps(const std::vector<StepRecord>& steps) {
  json list = json::array();
  for (const StepRecord& s : steps) {
    list.push_back({{"step", NameOf(s.step)},
                    {"applied", s.applied},
                    {"effect", NumberOrNull(s.effect)},
                    {"sigma", NumberOrNull(s.sigma)},
                    {"note", s.note}});
  }
  return list;
}

json RecordOfBand(const BandCalibration& band) {
  json windows = json::array();
  for (const Window& window : band.windows) windows.push_back(RecordOfWindow(window));
  const BandAlignment& a = band.alignment;
  return {{"wavelength_nm", band.band.wavelength_nm},
          {"fwhm_nm", band.band.fwhm_nm},
          {"frame", band.skin_files.empty() ? "" : band.skin_files[0]},
          {"frames", band.skin_files},
          {"spectralon_frames", band.spectralon_files},
          {"spectralon_reflectance", band.certified_reflectance},
          {"gray_card_drift", band.gray_card_drift.empty() ? json(nullptr) : json(band.gray_card_drift[0])},
          {"gray_card_drifts", band.gray_card_drift},
          {"windows", windows},
          {"alignment_shift_px", {a.dx_px, a.dy_px}},
          {"alignment_rotation_deg", a.angle_rad * 180.0 / 3.14159265358979323846},
          {"alignment_stretch_px", a.stretch_px},
          {"alignment_correlation", a.correlation},
          {"alignment_uncertainty_px", a.uncertainty_px},
          {"aligned", a.applied},
          {"median_reflectance", NumberOrNull(band.median_reflectance)},
          {"median_noise", NumberOrNull(band.median_noise)},
          {"saturated_share", band.saturated_share},
          {"masked_share", band.masked_share},
          {"correlation", RecordOfCorrelation(band.correlation)},
          {"blur_px", {band.blur_px.x, band.blur_px.y}},
          {"steps", RecordOfSteps(band.steps)},
          {"systematic_sigma", band.systematic_sigma},
          {"effective_wavelength_nm",
           band.effective_wavelength_nm > 0.0 ? json(band.effective_wavelength_nm) : json(nullptr)},
          {"dropped", band.dropped},
          {"notes", band.notes}};
}

json RecordOfMeanCorrelation(const NoiseCorrelation& mean) {
  json record = RecordOfCorrelation(mean);
  record["lags"] = "pixels of the patch, from 0";
  record["note"] =
      "neighbouring pixels share photosites, so their noise is correlated; sigma is right for each pixel, "
      "but the mean "
      "of n pixels is known less well than sigma / sqrt(n)";
  return record;
}

class Pictures {
 public:
  explicit Pictures(std::filesystem::path directory) : directory_(std::move(directory)) {}
  void Add(const std::string& title, const std::string& name, const Plane<Rgb8>& picture) {
    WritePng(directory_ / name, picture);
    list_.push_back({{"title", title}, {"file", directory_.filename().string() + "/" + name}});
  }
  const json& list() const { return list_; }

 private:
  std::filesystem::path directory_;
  json list_ = json::array();
};

json RecordOfLinearity(const Linearity& linearity) {
  json record{{"used", nullptr}, {"used_sigma", nullptr}, {"measured", nullptr}, {"measured_sigma", nullptr}};
  if (linearity.used) {
    record["used"] = linearity.used->value;
    record["used_sigma"] = linearity.used->sigma;
  }
  if (linearity.measured) {
    record["measured"] = linearity.measured->nonlinearity.value;
    record["measured_sigma"] = linearity.measured->nonlinearity.sigma;
    record["points"] = linearity.measured->points;
    record["chi2"] = linearity.measured->chi2;
  }
  record["note"] = linearity.note;
  return record;
}

}  // namespace

json CalibrationRecord(const CalibrationResult& result) {
  json record{{"session", result.session},
              {"edge_mask_px", result.edge_mask_px},
              {"pixel_size_mm", result.stack.pixel_size_mm.value_or(0.0)},
              {"pixel_size_sigma_mm", result.pixel_size_sigma_mm},
              {"hot_photosites_share", result.hot_share},
              {"linearity", RecordOfLinearity(result.linearity)},
              {"bands", json::array()},
              {"noise", json::array()},
              {"correlation", RecordOfMeanCorrelation(result.correlation)},
              {"notes", result.notes}};
  for (const StageSeconds& stage : result.seconds) record["seconds"][stage.stage] = stage.seconds;
  for (const BandCalibration& band : result.bands) record["bands"].push_back(RecordOfBand(band));
  for (const auto& [iso, model] : result.noise) {
    record["noise"].push_back({{"iso", iso},
                               {"gain_dn_per_electron", model.gain},
                               {"read_noise_dn", std::sqrt(model.read_variance)},
                               {"points", model.points}});
  }
  return record;
}

std::filesystem::path CalibrationRecordPath(const std::filesystem::path& stack_path) {
  std::filesystem::path path = stack_path;
  return path.replace_extension(".calibration.json");
}

void WriteCalibration(const std::filesystem::path& stack_path, const CalibrationResult& result) {
  std::filesystem::path directory = stack_path;
  Pictures pictures(directory.replace_extension(".calibration"));
  std::size_t k = 0;
  for (const BandCalibration& band : result.bands) {
    const std::string name = NameOf(band.band.wavelength_nm);
    pictures.Add("Captured frame, " + name, name + "_frame.png",
                 OutlinedFrame(band.picture, band.picture_scale, band.windows[0].corners));
    if (band.dropped) continue;
    const PlaneF& reflectance = result.stack.reflectance[k++];
    pictures.Add("Calibrated reflectance, " + name, name + "_reflectance.png",
                 Colourise(reflectance, ColourMap::kGray, RobustScale(reflectance.values(), 0.5)));
  }
  json record = CalibrationRecord(result);
  record["pictures"] = pictures.list();
  WriteFileAtomically(CalibrationRecordPath(stack_path), record.dump(2) + "\n");
  WriteReflectanceStack(stack_path, result.stack);
}

}  // namespace dermap
