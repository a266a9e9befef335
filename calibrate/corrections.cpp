// SPDX-License-Identifier: Apache-2.0
// Factors of polarization and gel.
#include "calibrate/corrections.h"

#include <algorithm>
#include <cmath>

#include "common/optics/fresnel.h"

namespace dermap {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kDirections = 400;  // of the integral over diffuse light
// Relative, of what goes back and forth, which is taken for diffuse; adding-doubling finds it off by up to a
// ninth.
constexpr double kWithinUncertainty = 0.2;

double AtWavelength(const std::vector<double>& nm, const std::vector<double>& values, double wavelength_nm) {
  if (nm.size() < 2) return values[0];
  const auto right = std::upper_bound(nm.begin(), nm.end(), wavelength_nm);
  if (right == nm.begin()) return values.front();
  if (right == nm.end()) return values.back();
  const auto i = static_cast<std::size_t>(right - nm.begin());
  const double f = (wavelength_nm - nm[i - 1]) / (nm[i] - nm[i - 1]);
  return values[i - 1] + f * (values[i] - values[i - 1]);
}

// Through a film between two media, at the cosine in n_from: both faces and all reflections between them,
// incoherent, since the film is many wavelengths thick.
double FilmTransmittance(double cos_from, double n_from, double n_film, double n_to) {
  const double sin_film = n_from / n_film * std::sqrt(1.0 - cos_from * cos_from);
  if (sin_film >= 1.0) return 0.0;
  const double cos_film = std::sqrt(1.0 - sin_film * sin_film);
  const double first = FresnelReflectance(cos_from, n_from, n_film);
  const double second = FresnelReflectance(cos_film, n_film, n_to);
  return (1.0 - first) * (1.0 - second) / (1.0 - first * second);
}

struct GelParts {
  double faces = 1.0;   // in and out
  double within = 1.0;  // of the light that goes back and forth below the face
};

double CosineOf(double degrees) {
  return std::cos(degrees * kPi / 180.0);
}

// Into bare skin, and by reversed rays out of it.
double BareTransmittance(double degrees, double n_skin) {
  return 1.0 - FresnelReflectance(CosineOf(degrees), 1.0, n_skin);
}

GelParts GelPartsOf(double n_gel, double n_skin, const RigAngles& angles, double reflectance) {
  const double in_film = FilmTransmittance(CosineOf(angles.light_deg), 1.0, n_gel, n_skin);
  const double out_film = FilmTransmittance(CosineOf(angles.view_deg), 1.0, n_gel, n_skin);
  GelParts parts;
  parts.faces = BareTransmittance(angles.light_deg, n_skin) / in_film *
                BareTransmittance(angles.view_deg, n_skin) / out_film;
  // R = T_in T_out / n^2 rho / (1 - F rho), rho the albedo of what lies below the face: a reflectance factor.
  const double bare = DiffuseFresnelReflectance(n_skin, 1.0);
  const double film = DiffuseReflectanceUnderFilm(n_skin, n_gel);
  const double r = std::clamp(reflectance, 0.0, 0.95);
  const double rho = r / (in_film * out_film / (n_skin * n_skin) + film * r);
  parts.within = (1.0 - film * rho) / (1.0 - bare * rho);
  return parts;
}

}  // namespace

std::optional<Step> StepFromName(std::string_view name) {
  const auto found = std::find(kStepNames.begin(), kStepNames.end(), name);
  if (found == kStepNames.end()) return std::nullopt;
  return static_cast<Step>(found - kStepNames.begin());
}

std::string AllStepNames() {
  std::string all;
  for (const std::string_view name : kStepNames) all += (all.empty() ? "" : ", ") + std::string(name);
  return all;
}

Known PolarizationFactor(const PolarizationConfig& config, double wavelength_nm) {
  const double white =
      1.0 + config.sign * AtWavelength(config.wavelengths_nm, config.spectralon, wavelength_nm);
  const double skin = 1.0 + config.sign * AtWavelength(config.wavelengths_nm, config.skin, wavelength_nm);
  if (config.sign == 0) return {1.0, 0.0};
  const double factor = white / skin;
  return {factor, factor * std::hypot(config.spectralon_sigma / white, config.skin_sigma / skin)};
}

double SpectralonSignal(const PolarizationConfig& config, double wavelength_nm) {
  return 1.0 + config.sign * AtWavelength(config.wavelengths_nm, config.spectralon, wavelength_nm);
}

// R = (R_spectralon S_skin / S_spectralon (1 + sign a_spectralon) - leak) / (1 + sign a_skin).
double LeakInReflectance(const PolarizationConfig& config, double wavelength_nm, bool polarization_done) {
  const double skin = 1.0 + config.sign * AtWavelength(config.wavelengths_nm, config.skin, wavelength_nm);
  return 1.0 / (polarization_done ? skin : SpectralonSignal(config, wavelength_nm));
}

double DiffuseReflectanceUnderFilm(double n_skin, double n_film) {
  double sum = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double cosine = (i + 0.5) / kDirections;
    sum += 2.0 * cosine * (1.0 - FilmTransmittance(cosine, n_skin, n_film, 1.0)) / kDirections;
  }
  return sum;
}

Known GelFactor(const Known& n_gel, double n_skin, const RigAngles& angles, double reflectance) {
  const GelParts parts = GelPartsOf(n_gel.value, n_skin, angles, reflectance);
  const auto total = [&](double n) {
    const GelParts p = GelPartsOf(n, n_skin, angles, reflectance);
    return p.faces * p.within;
  };
  const double by_index = 0.5 * (total(n_gel.value + n_gel.sigma) - total(n_gel.value - n_gel.sigma));
  return {parts.faces * parts.within, std::hypot(by_index, kWithinUncertainty * (parts.within - 1.0))};
}

double AnglesFactor(const RigAngles& angles, double n_skin) {
  const RigAngles model;
  const auto both = [&](const RigAngles& a) {
    return BareTransmittance(a.light_deg, n_skin) * BareTransmittance(a.view_deg, n_skin);
  };
  return both(angles) / both(model);
}

}  // namespace dermap
