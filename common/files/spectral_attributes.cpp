// SPDX-License-Identifier: Apache-2.0
// Attributes of stacks and maps.
#include "common/files/spectral_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "common/core/error.h"
#include "common/files/rig.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr std::array<std::string_view, 2> kIlluminationNames{"window", "uniform"};
constexpr std::array<std::string_view, 2> kTapeNames{"free", "black"};
constexpr std::array<std::string_view, 2> kGeometryNames{"hemispherical", "0/30"};

constexpr const char* kPixelSize = "dermap:pixelSizeMm";
constexpr const char* kIllumination = "dermap:illumination";
constexpr const char* kTape = "dermap:tape";
constexpr const char* kGeometry = "dermap:geometry";
constexpr const char* kWidths = "dermap:fwhmNm";
constexpr const char* kSharedError = "dermap:sharedError";
constexpr const char* kCorrelationX = "dermap:noiseCorrelationX";
constexpr const char* kCorrelationY = "dermap:noiseCorrelationY";

template <class Enum>
Enum FromName(const std::array<std::string_view, 2>& names, const std::string& where,
              const std::string& name) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<Enum>(i);
  }
  throw InputError(where + " is \"" + Shorten(name, 60) + "\"; expected " + Join(names, " or "));
}

// The text of an attribute, or `fallback`; an attribute of another type is an error.
std::string TextAttribute(const std::string& file, const ExrImage& image, const std::string& name,
                          const std::string& fallback) {
  const auto found = image.texts.find(name);
  if (found != image.texts.end()) return found->second;
  if (image.HasAttribute(name)) throw InputError(file + ": " + name + " is a number; expected a text");
  return fallback;
}

}  // namespace

std::string IlluminationName(Illumination illumination) {
  return std::string(kIlluminationNames[static_cast<std::size_t>(illumination)]);
}
std::string TapeName(Tape tape) {
  return std::string(kTapeNames[static_cast<std::size_t>(tape)]);
}
std::string GeometryName(Geometry geometry) {
  return std::string(kGeometryNames[static_cast<std::size_t>(geometry)]);
}

Illumination IlluminationFromName(const std::string& where, const std::string& name) {
  return FromName<Illumination>(kIlluminationNames, where, name);
}
Tape TapeFromName(const std::string& where, const std::string& name) {
  return FromName<Tape>(kTapeNames, where, name);
}
Geometry GeometryFromName(const std::string& where, const std::string& name) {
  return FromName<Geometry>(kGeometryNames, where, name);
}

double CheckedPixelSize(const std::string& where, double pixel_size_mm) {
  if (std::isfinite(pixel_size_mm) && pixel_size_mm >= 1e-4 && pixel_size_mm <= 100.0) return pixel_size_mm;
  throw InputError(where + " is " + FormatNumber(pixel_size_mm) +
                   "; expected a pixel's side in mm, 0.0001 to 100");
}

void CheckBands(const std::string& file, const std::vector<Band>& bands) {
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const auto [wavelength, width] = bands[i];
    if (!(wavelength >= kShortestWavelengthNm && wavelength <= kLongestWavelengthNm)) {
      throw InputError(
          file + " has a band at " + FormatNumber(wavelength) +
          " nm; expected 350 to 1000 nm, where the spectra of skin are known; remedy: leave it out");
    }
    if (!(width >= 0.0 && width <= 200.0)) {
      throw InputError(file + ": the band at " + FormatNumber(wavelength) + " nm has a width of " +
                       FormatNumber(width) + " nm; expected 0 (monochromatic) to 200");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (std::abs(bands[j].wavelength_nm - wavelength) < 1e-3) {
        throw InputError(file + " has two bands at " + FormatNumber(wavelength) +
                         " nm; expected each wavelength once; remedy: average them or leave one out");
      }
    }
  }
}

FileConditions ReadConditions(const std::string& file, const ExrImage& image) {
  FileConditions conditions;
  if (const auto found = image.numbers.find(kPixelSize); found != image.numbers.end()) {
    conditions.pixel_size_mm = CheckedPixelSize(file + ": " + kPixelSize, found->second);
  } else if (image.HasAttribute(kPixelSize)) {
    throw InputError(file + ": " + kPixelSize + " is not a number; expected a float, a pixel's side in mm");
  }
  const std::string prefix = file + ": ";
  conditions.illumination = IlluminationFromName(
      prefix + kIllumination,
      TextAttribute(file, image, kIllumination, IlluminationName(conditions.illumination)));
  conditions.tape =
      TapeFromName(prefix + kTape, TextAttribute(file, image, kTape, TapeName(conditions.tape)));
  conditions.geometry = GeometryFromName(
      prefix + kGeometry, TextAttribute(file, image, kGeometry, GeometryName(conditions.geometry)));
  return conditions;
}

void WriteConditions(const FileConditions& conditions, ExrImage& image) {
  if (conditions.pixel_size_mm) image.numbers[kPixelSize] = *conditions.pixel_size_mm;
  image.texts[kIllumination] = IlluminationName(conditions.illumination);
  image.texts[kTape] = TapeName(conditions.tape);
  image.texts[kGeometry] = GeometryName(conditions.geometry);
}

void ReadWidths(const std::string& file, const ExrImage& image, std::vector<Band>& bands) {
  if (!image.HasAttribute(kWidths)) return;
  const auto found = image.lists.find(kWidths);
  if (found == image.lists.end()) {
    throw InputError(file + ": " + kWidths +
                     " is not a list of floats; expected one width in nm for each band");
  }
  if (found->second.size() != bands.size()) {
    throw InputError(file + ": " + kWidths + " has " + std::to_string(found->second.size()) +
                     " values; expected " + std::to_string(bands.size()) +
                     ", one for each band in order of wavelength");
  }
  for (std::size_t i = 0; i < bands.size(); ++i) bands[i].fwhm_nm = DecimalOf(found->second[i]);
}

void WriteWidths(const std::vector<Band>& bands, ExrImage& image) {
  std::vector<float> widths;
  bool any = false;
  for (const Band& band : bands) {
    widths.push_back(static_cast<float>(band.fwhm_nm));
    any = any || band.fwhm_nm > 0.0;
  }
  if (any) image.lists[kWidths] = widths;
}

void CheckNoiseCorrelation(const std::string& where, const std::vector<float>& lags) {
  const bool good = std::all_of(lags.begin(), lags.end(), [](float c) { return c >= -1.0f && c <= 1.0f; });
  if (!good || lags.size() > kMaxCorrelationLags) {
    throw InputError(where + " is not a list of at most " + std::to_string(kMaxCorrelationLags) +
                     " correlations between -1 and 1, for pixels 1, 2, ... apart");
  }
}

void ReadNoiseCorrelation(const std::string& file, const ExrImage& image, ReflectanceStack& stack) {
  const auto read = [&](const char* name) -> std::vector<float> {
    if (!image.HasAttribute(name)) return {};
    const auto found = image.lists.find(name);
    if (found == image.lists.end()) throw InputError(file + ": " + name + " is not a list of floats");
    CheckNoiseCorrelation(file + ": " + name, found->second);
    return found->second;
  };
  stack.noise_correlation_x = read(kCorrelationX);
  stack.noise_correlation_y = read(kCorrelationY);
}

void WriteNoiseCorrelation(const ReflectanceStack& stack, ExrImage& image) {
  if (!stack.noise_correlation_x.empty()) image.lists[kCorrelationX] = stack.noise_correlation_x;
  if (!stack.noise_correlation_y.empty()) image.lists[kCorrelationY] = stack.noise_correlation_y;
}

double CheckedSharedError(const std::string& where, double shared_error) {
  if (shared_error >= 0.0 && shared_error <= 0.1) return shared_error;
  throw InputError(where + " is " + FormatNumber(shared_error) +
                   "; expected a share of the reflectance, 0 to 0.1");
}

void ReadSharedError(const std::string& file, const ExrImage& image, ReflectanceStack& stack) {
  if (!image.HasAttribute(kSharedError)) return;
  const auto found = image.numbers.find(kSharedError);
  if (found == image.numbers.end()) throw InputError(file + ": " + kSharedError + " is not a number");
  stack.shared_error = CheckedSharedError(file + ": " + kSharedError, found->second);
}

void WriteSharedError(const ReflectanceStack& stack, ExrImage& image) {
  if (stack.shared_error) image.numbers[kSharedError] = *stack.shared_error;
}

}  // namespace dermap
