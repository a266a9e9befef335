// SPDX-License-Identifier: Apache-2.0
// CIE 1931 colorimetry and sRGB.
#include "common/spectra/colour.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <sstream>
#include <string>

#include "common/core/error.h"

namespace dermap {
namespace {

Eigen::Vector3d FromXy(double x, double y) {
  return {x / y, 1.0, (1.0 - x - y) / y};
}

// Columns are the primaries, scaled such that (1, 1, 1) is the white point.
Eigen::Matrix3d MakeXyzFromSrgb() {
  Eigen::Matrix3d primaries;  // IEC 61966-2-1, table 1 (those of ITU-R BT.709)
  primaries << FromXy(0.64, 0.33), FromXy(0.30, 0.60), FromXy(0.15, 0.06);
  const Eigen::Vector3d scale = primaries.inverse() * FromXy(0.3127, 0.3290);
  return primaries * scale.asDiagonal();
}

// K. M. Lam, "Metamerism and colour constancy", 1985: the cone-like space that ICC profiles adapt in.
Eigen::Matrix3d Bradford() {
  Eigen::Matrix3d m;
  m << 0.8951, 0.2664, -0.1614,  //
      -0.7502, 1.7135, 0.0367,   //
      0.0389, -0.0685, 1.0296;
  return m;
}

Eigen::Vector3d AsVector(const Xyz& v) {
  return {v[0], v[1], v[2]};
}
std::array<double, 3> AsArray(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

const char* Column(Illuminant illuminant) {
  switch (illuminant) {
    case Illuminant::kD65:
      return "D65";
    case Illuminant::kD50:
      return "D50";
    case Illuminant::kA:
      return "A";
  }
  return "";
}

void CheckWavelengths(std::span<const double> wavelengths_nm) {
  bool ascending = !wavelengths_nm.empty();
  for (std::size_t i = 0; i < wavelengths_nm.size(); ++i) {
    ascending = ascending && std::isfinite(wavelengths_nm[i]) &&
                (i == 0 || wavelengths_nm[i] > wavelengths_nm[i - 1]);
  }
  if (ascending) return;
  std::ostringstream message;
  message << "A colour needs at least one band, in ascending order of wavelength; found";
  for (const double wavelength : wavelengths_nm) message << ' ' << wavelength;
  message << (wavelengths_nm.empty() ? " none." : " nm.");
  throw InputError(message.str());
}

}  // namespace

LinearRgb LinearSrgbFromXyz(const Xyz& xyz) {
  static const Eigen::Matrix3d kSrgbFromXyz = MakeXyzFromSrgb().inverse();
  return AsArray(kSrgbFromXyz * AsVector(xyz));
}

double EncodeSrgb(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;  // IEC 61966-2-1
}

std::uint8_t EncodeSrgb8(double linear) {
  return static_cast<std::uint8_t>(std::lround(255.0 * EncodeSrgb(linear)));
}

Rgb8 EncodeSrgb8(const LinearRgb& linear) {
  return {EncodeSrgb8(linear[0]), EncodeSrgb8(linear[1]), EncodeSrgb8(linear[2])};
}

Xyz AdaptWhite(const Xyz& xyz, const Xyz& from_white, const Xyz& to_white) {
  const Eigen::Matrix3d cone_from_xyz = Bradford();
  const Eigen::Vector3d from = cone_from_xyz * AsVector(from_white);
  const Eigen::Vector3d to = cone_from_xyz * AsVector(to_white);
  const Eigen::Vector3d cone = (cone_from_xyz * AsVector(xyz)).cwiseProduct(to.cwiseQuotient(from));
  return AsArray(cone_from_xyz.inverse() * cone);
}

Xyz SrgbWhite() {
  return AsArray(FromXy(0.3127, 0.3290));
}

ColourObserver::ColourObserver(const std::filesystem::path& spectra_dir, Illuminant illuminant) {
  const std::array<const char*, 3> columns{"xbar", "ybar", "zbar"};
  for (int i = 0; i < 3; ++i) {
    matching_[i] = ReadSpectrumCsv(spectra_dir / "cie1931_2deg.csv", columns[i]);
  }
  const auto power = ReadSpectrumCsv(spectra_dir / "cie_illuminants.csv", Column(illuminant));
  first_nm_ = std::ceil(std::max(matching_[1].first_nm(), power.first_nm()));
  const double last_nm = std::min(matching_[1].last_nm(), power.last_nm());
  double luminance = 0.0;
  for (double nm = first_nm_; nm <= last_nm; nm += 1.0) {
    Xyz& weight = weights_.emplace_back();
    for (int i = 0; i < 3; ++i) weight[i] = matching_[i].At(nm) * power.At(nm);
    luminance += weight[1];
  }
  for (Xyz& weight : weights_) {
    for (int i = 0; i < 3; ++i) white_[i] += (weight[i] /= luminance);
  }
}

std::vector<Xyz> ColourObserver::BandWeights(std::span<const double> wavelengths_nm) const {
  CheckWavelengths(wavelengths_nm);
  std::vector<Xyz> result(wavelengths_nm.size(), Xyz{});
  const std::size_t last = wavelengths_nm.size() - 1;
  for (std::size_t sample = 0; sample < weights_.size(); ++sample) {
    const double nm = first_nm_ + static_cast<double>(sample);
    const auto above = std::upper_bound(wavelengths_nm.begin(), wavelengths_nm.end(), nm);
    const std::size_t count_below = above - wavelengths_nm.begin();
    const std::size_t left = std::max<std::size_t>(count_below, 1) - 1;
    const std::size_t right = std::min(count_below, last);
    const double share =
        left == right ? 0.0 : (nm - wavelengths_nm[left]) / (wavelengths_nm[right] - wavelengths_nm[left]);
    for (int i = 0; i < 3; ++i) {
      result[left][i] += (1.0 - share) * weights_[sample][i];
      result[right][i] += share * weights_[sample][i];
    }
  }
  return result;
}

Xyz ColourObserver::XyzOf(std::span<const double> wavelengths_nm, std::span<const double> reflectance) const {
  assert(wavelengths_nm.size() == reflectance.size());
  const auto weights = BandWeights(wavelengths_nm);
  Xyz xyz{};
  for (std::size_t band = 0; band < weights.size(); ++band) {
    for (int i = 0; i < 3; ++i) xyz[i] += weights[band][i] * reflectance[band];
  }
  return xyz;
}

LinearRgb ColourObserver::AdaptedRgb(const Xyz& xyz) const {
  return LinearSrgbFromXyz(AdaptWhite(xyz, white_, SrgbWhite()));
}

LinearRgb ColourObserver::LinearSrgbOf(std::span<const double> wavelengths_nm,
                                       std::span<const double> reflectance) const {
  return AdaptedRgb(XyzOf(wavelengths_nm, reflectance));
}

Plane<Rgb8> ColourObserver::Picture(std::span<const double> wavelengths_nm,
                                    std::span<const PlaneF> reflectance, double exposure) const {
  assert(wavelengths_nm.size() == reflectance.size());
  std::vector<LinearRgb> weights;
  for (const Xyz& weight : BandWeights(wavelengths_nm)) weights.push_back(AdaptedRgb(weight));
  Plane<Rgb8> picture(reflectance[0].width(), reflectance[0].height());
  for (std::size_t pixel = 0; pixel < picture.size(); ++pixel) {
    LinearRgb rgb{};
    for (std::size_t band = 0; band < weights.size(); ++band) {
      const double value = exposure * reflectance[band].data()[pixel];
      for (int i = 0; i < 3; ++i) rgb[i] += weights[band][i] * value;
    }
    picture.data()[pixel] = std::isfinite(rgb[0]) ? EncodeSrgb8(rgb) : kMissingColour;
  }
  return picture;
}

Rgb8 ColourObserver::WavelengthColour(double wavelength_nm) const {
  constexpr Rgb8 kInvisible{128, 128, 128};
  if (wavelength_nm < matching_[1].first_nm() || wavelength_nm > matching_[1].last_nm()) return kInvisible;
  const Xyz xyz{matching_[0].At(wavelength_nm), matching_[1].At(wavelength_nm),
                matching_[2].At(wavelength_nm)};
  LinearRgb rgb = LinearSrgbFromXyz(xyz);
  const double white = std::max(0.0, -std::min({rgb[0], rgb[1], rgb[2]}));
  const double peak = std::max({rgb[0], rgb[1], rgb[2]}) + white;
  if (!(peak > 1e-6)) return kInvisible;
  for (double& c : rgb) c = (c + white) / peak;
  return EncodeSrgb8(rgb);
}

}  // namespace dermap
