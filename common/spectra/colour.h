// SPDX-License-Identifier: Apache-2.0
// Colour of a reflectance spectrum that is known at a few bands: CIE 1931 XYZ under an illuminant, then sRGB.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/core/image.h"
#include "common/spectra/sampled_spectrum.h"

namespace dermap {

using Xyz = std::array<double, 3>;        // CIE 1931, 2 degree observer; Y = 1 for the perfect white
using LinearRgb = std::array<double, 3>;  // sRGB primaries, before the transfer curve
using Rgb8 = std::array<std::uint8_t, 3>;

enum class Illuminant { kD65, kD50, kA };

inline constexpr Rgb8 kMissingColour{236, 64,
                                     200};  // for pixels that have no value: in none of our colour maps

// IEC 61966-2-1: from the primaries and the white point (0.3127, 0.3290), not from its matrix of four
// decimals, so that the white point becomes exactly (1, 1, 1).
LinearRgb LinearSrgbFromXyz(const Xyz& xyz);
double EncodeSrgb(double linear);         // transfer curve; clamps to 0...1
std::uint8_t EncodeSrgb8(double linear);  // rounded to 8 bits
Rgb8 EncodeSrgb8(const LinearRgb& linear);

// Bradford's chromatic adaptation: what `xyz` seen under `from_white` looks like under `to_white`.
Xyz AdaptWhite(const Xyz& xyz, const Xyz& from_white, const Xyz& to_white);
Xyz SrgbWhite();  // x = 0.3127, y = 0.3290, Y = 1

// The standard observer under one illuminant.
//
// Between bands a reflectance spectrum is taken as piecewise linear, beyond the first and last band as
// constant. With eight bands the colours are therefore plausible rather than colorimetric. Colours are
// adapted from the illuminant's white to sRGB's, so a reflectance of 1 is white under every illuminant.
class ColourObserver {
 public:
  explicit ColourObserver(const std::filesystem::path& spectra_dir, Illuminant illuminant = Illuminant::kD65);

  const Xyz& white() const noexcept { return white_; }

  // XYZ = sum over bands of weight * reflectance: both the interpolation and the integral are linear.
  // Wavelengths in nm, strictly ascending, at least one; throws InputError otherwise.
  std::vector<Xyz> BandWeights(std::span<const double> wavelengths_nm) const;
  Xyz XyzOf(std::span<const double> wavelengths_nm, std::span<const double> reflectance) const;
  LinearRgb LinearSrgbOf(std::span<const double> wavelengths_nm, std::span<const double> reflectance) const;

  // One picture out of one plane a band; `exposure` multiplies the reflectance. A pixel that misses a band
  // (NaN) gets kMissingColour.
  Plane<Rgb8> Picture(std::span<const double> wavelengths_nm, std::span<const PlaneF> reflectance,
                      double exposure = 1.0) const;

  // What light of one wavelength looks like, as bright as the screen allows, with as much white as its gamut
  // demands: a label for a band, not a measurement. Gray where the eye sees nothing.
  Rgb8 WavelengthColour(double wavelength_nm) const;

 private:
  LinearRgb AdaptedRgb(const Xyz& xyz) const;

  std::array<SampledSpectrum, 3> matching_;  // xbar, ybar, zbar
  double first_nm_ = 0.0;
  std::vector<Xyz> weights_;  // xbar, ybar, zbar times illuminant, each nm from first_nm_, sum of Y = 1
  Xyz white_{};
};

}  // namespace dermap
