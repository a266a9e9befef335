// SPDX-License-Identifier: Apache-2.0
// Keys and ranges of [calibration], [polarization] and [gel].
#include "common/files/rig_optics.h"

#include <nlohmann/json.hpp>

#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kTapeSigma = 0.005;
constexpr double kStrayLightSigma = 0.001;
constexpr double kGelSigma = 0.01;

std::optional<Known> OptionalKnown(TomlTable& table, const std::string& key, double default_sigma,
                                   double lower, double upper) {
  const bool there = table.Has(key);
  const Known known{table.Number(key, 0.0, lower, upper),
                    table.Number(key + "_sigma", default_sigma, 0.0, upper)};
  return there ? std::optional(known) : std::nullopt;
}

void ReadCalibration(TomlTable& table, RigOptics& optics) {
  optics.certificate.value = table.Number("certificate_factor", optics.certificate.value, 0.5, 2.0);
  optics.certificate.sigma = table.Number("certificate_sigma", optics.certificate.sigma, 0.0, 0.5);
  optics.tape_reflectance = OptionalKnown(table, "tape_reflectance", kTapeSigma, 0.0, 0.5);
  optics.stray_light = OptionalKnown(table, "stray_light", kStrayLightSigma, 0.0, 0.5);
  optics.nonlinearity = OptionalKnown(table, "nonlinearity", 0.0, -0.5, 0.5);
  optics.window_sigma_mm = table.Number("window_sigma_mm", optics.window_sigma_mm, 0.0, 5.0);
  optics.distortion_k1 = table.Number("distortion_k1", 0.0, -0.3, 0.3);
  optics.distortion_k2 = table.Number("distortion_k2", 0.0, -0.3, 0.3);
  optics.camera_csv = table.String("camera_csv", "");
  optics.flash_csv = table.String("flash_csv", "");
  table.Finish();
}

void CheckAmplitudes(const TomlTable& table, const PolarizationConfig& p, const std::string& key,
                     const std::vector<double>& values) {
  const std::size_t expected = std::max<std::size_t>(1, p.wavelengths_nm.size());
  bool good = values.size() == expected;
  for (const double v : values) good = good && v > -0.9 && v < 0.9;
  if (!good) {
    throw InputError(table.Where(key) + ": '" + key + "' holds " + std::to_string(values.size()) +
                     " numbers; expected " + std::to_string(expected) +
                     " between -0.9 and 0.9, one for each of wavelengths_nm (or one in all without them)");
  }
}

PolarizationConfig ReadPolarization(TomlTable& table) {
  PolarizationConfig p;
  p.sign = table.RequiredInteger("sign", -1, 1);
  p.wavelengths_nm = table.Numbers("wavelengths_nm", {});
  for (std::size_t i = 1; i < p.wavelengths_nm.size(); ++i) {
    if (p.wavelengths_nm[i] <= p.wavelengths_nm[i - 1])
      throw InputError(table.Where("wavelengths_nm") + ": 'wavelengths_nm' does not ascend; remedy: sort it");
  }
  p.spectralon = table.Numbers("spectralon", p.spectralon);
  p.skin = table.Numbers("skin", p.skin);
  CheckAmplitudes(table, p, "spectralon", p.spectralon);
  CheckAmplitudes(table, p, "skin", p.skin);
  p.spectralon_sigma = table.Number("spectralon_sigma", p.spectralon_sigma, 0.0, 0.5);
  p.skin_sigma = table.Number("skin_sigma", p.skin_sigma, 0.0, 0.5);
  p.leak = {table.Number("leak", 0.0, 0.0, 0.2), table.Number("leak_sigma", 0.0, 0.0, 0.2)};
  table.Finish();
  return p;
}

}  // namespace

RigOptics ReadRigOptics(TomlTable& rig) {
  RigOptics optics;
  if (auto table = rig.Table("calibration")) ReadCalibration(*table, optics);
  if (auto table = rig.Table("polarization")) optics.polarization = ReadPolarization(*table);
  if (auto table = rig.Table("gel")) {
    optics.gel = Known{table->RequiredNumber("n", 1.0, 2.0), table->Number("n_sigma", kGelSigma, 0.0, 0.5)};
    table->Finish();
  }
  return optics;
}

void AddRigOptics(const RigOptics& optics, nlohmann::json& rig) {
  nlohmann::json table;
  const RigOptics fallback;
  const auto add = [&](const std::string& key, const std::optional<Known>& known) {
    if (!known) return;
    table[key] = known->value;
    table[key + "_sigma"] = known->sigma;
  };
  if (optics.certificate.value != 1.0) table["certificate_factor"] = optics.certificate.value;
  if (optics.certificate.sigma != fallback.certificate.sigma)
    table["certificate_sigma"] = optics.certificate.sigma;
  add("tape_reflectance", optics.tape_reflectance);
  add("stray_light", optics.stray_light);
  add("nonlinearity", optics.nonlinearity);
  if (optics.window_sigma_mm != fallback.window_sigma_mm) table["window_sigma_mm"] = optics.window_sigma_mm;
  if (optics.distortion_k1 != 0.0) table["distortion_k1"] = optics.distortion_k1;
  if (optics.distortion_k2 != 0.0) table["distortion_k2"] = optics.distortion_k2;
  if (!optics.camera_csv.empty()) table["camera_csv"] = optics.camera_csv.generic_string();
  if (!optics.flash_csv.empty()) table["flash_csv"] = optics.flash_csv.generic_string();
  if (!table.is_null()) rig["calibration"] = table;
  if (optics.polarization) {
    const PolarizationConfig& p = *optics.polarization;
    rig["polarization"] = {{"sign", p.sign},
                           {"spectralon", p.spectralon},
                           {"skin", p.skin},
                           {"spectralon_sigma", p.spectralon_sigma},
                           {"skin_sigma", p.skin_sigma},
                           {"leak", p.leak.value},
                           {"leak_sigma", p.leak.sigma}};
    if (!p.wavelengths_nm.empty()) rig["polarization"]["wavelengths_nm"] = p.wavelengths_nm;
  }
  if (optics.gel) rig["gel"] = {{"n", optics.gel->value}, {"n_sigma", optics.gel->sigma}};
}

}  // namespace dermap
