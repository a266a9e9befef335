// SPDX-License-Identifier: Apache-2.0
// The spectrum that a spectrophotometer sees of homogeneous two-layer skin, a closed form of its parameters
// that can be differentiated automatically.
#pragma once

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "common/tissue/tissue.h"
#include "common/transport/conditions.h"
#include "fit/spectra/edge_loss.h"
#include "fit/spectra/measured_skin.h"
#include "fit/spectra/skin_totals.h"

namespace dermap {

// What measured the spectra.
struct Instrument {
  Aperture aperture;
  double fwhm_nm = 10.0;                         // of each band, a triangle; 0: monochromatic
  Geometry geometry = Geometry::kHemispherical;  // or seen at 30 degrees; d/8 is hemispherical by reciprocity
  bool specular_included = false;  // the mirror reflection of the skin's surface is in the measurement
};

class SpectrumModel {
 public:
  // Of `tissue` the refractive indices, the anisotropy and the junction absorbance are used. Solves the
  // tables.
  SpectrumModel(const Instrument& instrument, const TissueConfig& tissue, const Chromophores& chromophores,
                std::vector<double> wavelengths_nm, const ProgressFunction& progress);

  const std::vector<double>& wavelengths_nm() const { return wavelengths_nm_; }

  // Reflectance at every wavelength; Scalar is double or a type of automatic differentiation with a member
  // `a` that holds its value.
  template <class Scalar>
  void Predict(const std::array<Scalar, kSkinParameterCount>& skin, Scalar* reflectance) const;

 private:
  struct Point {  // one wavelength at which the skin is evaluated
    double eumelanin, pheomelanin, oxyhemoglobin, deoxyhemoglobin, carotene, baseline;  // 1/mm
    double mu_s_reduced;             // published, epidermis
    double log_relative_wavelength;  // ln(wavelength / 550 nm)
  };
  struct Share {
    int point;
    double weight;
  };

  static Point PointAt(double wavelength_nm, const TissueConfig& tissue, const Chromophores& chromophores);
  template <class Scalar>
  Scalar ReflectanceAt(const Point& point, const std::array<Scalar, kSkinParameterCount>& skin) const;

  std::vector<double> wavelengths_nm_;
  std::vector<Point> points_;
  std::vector<std::vector<Share>> bands_;  // of each wavelength
  SkinTotals totals_;
  std::optional<EdgeLoss> edge_;
  double exit_angle_factor_ = 1.0;
  double specular_ = 0.0;
};

// Absorption of blood in vessels of one radius over that of the same blood, evenly spread [van Veen,
// Verkruysse, Sterenborg 2002]: (1 - exp(-2 mu_a r)) / (2 mu_a r), here by its series where mu_a r is small.
template <class Scalar>
Scalar PackedShare(const Scalar& mu_a_blood, const Scalar& radius_mm) {
  using std::exp;
  const Scalar x = 2.0 * mu_a_blood * radius_mm;
  if (x < 1e-3) return 1.0 - x / 2.0 + x * x / 6.0;
  return (1.0 - exp(-x)) / x;
}

namespace detail {

inline double ValueOf(double x) {
  return x;
}
template <class Jet>
double ValueOf(const Jet& x) {
  return x.a;
}

// A table's value as a function of three scalars that themselves are functions of what is differentiated by.
template <class Scalar>
Scalar LookUp(const Grid3& table, const Scalar& x, const Scalar& y, const Scalar& z) {
  const Grid3::Sample sample = table.At({ValueOf(x), ValueOf(y), ValueOf(z)});
  return sample.value + sample.slope[0] * (x - ValueOf(x)) + sample.slope[1] * (y - ValueOf(y)) +
         sample.slope[2] * (z - ValueOf(z));
}

}  // namespace detail

template <class Scalar>
Scalar SpectrumModel::ReflectanceAt(const Point& point,
                                    const std::array<Scalar, kSkinParameterCount>& skin) const {
  using std::exp;
  using std::log;
  const auto& [C_m, beta_m, C_he, C_bc, C_hd, gamma, amplitude, slope, thickness_mm, radius_mm, base,
               surface] = skin;
  const Scalar blood = gamma * point.oxyhemoglobin + (1.0 - gamma) * point.deoxyhemoglobin;
  const Scalar baseline = base * point.baseline;
  // [D08 eq. 10, 11], the dermis's blood packed in vessels.
  const Scalar mu_a_epidermis = C_m * (beta_m * point.eumelanin + (1.0 - beta_m) * point.pheomelanin) +
                                C_he * blood + C_bc * point.carotene + (1.0 - C_m - C_he - C_bc) * baseline;
  const Scalar mu_a_dermis = C_hd * blood * PackedShare(blood, radius_mm) + (1.0 - C_hd) * baseline;
  // [D08 eq. 12]
  const Scalar mu_s = amplitude * exp(slope * point.log_relative_wavelength) * point.mu_s_reduced;
  const Scalar log_mu_s = log(mu_s), log_upper = log(mu_a_epidermis + 1e-9),
               log_lower = log(mu_a_dermis + 1e-9);
  const Scalar log_thickness = log(thickness_mm);
  Scalar reflectance =
      exp(detail::LookUp<Scalar>(totals_.log_reflectance(), log_mu_s + log_thickness, log_upper - log_mu_s,
                                 log_lower - log_mu_s + std::log(2.0)));
  if (edge_) {
    reflectance *=
        1.0 - exp(detail::LookUp<Scalar>(edge_->log_loss(), log_mu_s, log_upper + log_thickness, log_lower));
  }
  return exit_angle_factor_ * reflectance + surface + specular_;
}

template <class Scalar>
void SpectrumModel::Predict(const std::array<Scalar, kSkinParameterCount>& skin, Scalar* reflectance) const {
  std::vector<Scalar> at;
  at.reserve(points_.size());
  for (const Point& point : points_) at.push_back(ReflectanceAt(point, skin));
  for (std::size_t band = 0; band < bands_.size(); ++band) {
    reflectance[band] = Scalar(0.0);
    for (const Share& share : bands_[band]) reflectance[band] += share.weight * at[share.point];
  }
}

}  // namespace dermap
