// SPDX-License-Identifier: Apache-2.0
// Reflectance stacks: the choice of format, and the checks that both formats share.
#include "common/files/stack.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/stack_parts.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

// The median of what is finite; 0 where nothing is.
float FiniteMedian(const PlaneF& plane) {
  std::vector<float> finite;
  finite.reserve(plane.size());
  std::copy_if(plane.values().begin(), plane.values().end(), std::back_inserter(finite),
               [](float v) { return std::isfinite(v); });
  if (finite.empty()) return 0.0f;
  const auto middle = finite.begin() + static_cast<std::ptrdiff_t>(finite.size() / 2);
  std::nth_element(finite.begin(), middle, finite.end());
  return *middle;
}

void CheckReflectance(const std::string& file, const Band& band, PlaneF& plane) {
  for (float& value : plane.values()) {
    if (!std::isfinite(value)) value = kMissing;
  }
  // Fractions of a diffuse white stay near 1 at most; per cent and raw counts are the usual mistakes.
  const float median = FiniteMedian(plane);
  if (median > 2.0f) {
    throw InputError(file + ": the band at " + FormatNumber(band.wavelength_nm) + " nm has a median of " +
                     FormatNumber(static_cast<double>(median)) +
                     "; expected reflectance as a fraction (0 to 1); remedy: divide by its scale");
  }
}

void CheckSigma(const std::string& file, const Band& band, const PlaneF& sigma) {
  for (const float value : sigma.values()) {
    if (value < 0.0f) {
      throw InputError(file + ": the sigma of the band at " + FormatNumber(band.wavelength_nm) +
                       " nm has the value " + FormatNumber(static_cast<double>(value)) +
                       "; expected standard deviations, 0 or more");
    }
  }
}

// All bands with sigma, or none.
void CheckSigmaCount(const std::string& file, const std::vector<BandPlanes>& bands) {
  const auto with_sigma =
      std::count_if(bands.begin(), bands.end(), [](const BandPlanes& band) { return !band.sigma.empty(); });
  if (with_sigma == 0 || with_sigma == static_cast<std::ptrdiff_t>(bands.size())) return;
  throw InputError(file + " has sigma for " + std::to_string(with_sigma) + " of its " +
                   std::to_string(bands.size()) +
                   " bands; expected it for all or none; remedy: add or remove the others");
}

void CheckNotEmpty(const std::string& file, const std::vector<PlaneF>& reflectance) {
  for (const PlaneF& plane : reflectance) {
    if (std::any_of(plane.values().begin(), plane.values().end(), [](float v) { return std::isfinite(v); }))
      return;
  }
  throw InputError(file +
                   " holds no value: every pixel of every band is missing (NaN); remedy: make it again");
}

bool IsEnvi(const std::filesystem::path& path) {
  return LowerCase(path.extension().string()) == ".hdr";
}

void CheckExtension(const std::filesystem::path& path) {
  if (IsEnvi(path) || LowerCase(path.extension().string()) == ".exr") return;
  throw InputError(path.string() + " has the extension '" + path.extension().string() +
                   "'; expected .exr (spectral OpenEXR) or .hdr (ENVI)");
}

}  // namespace

ReflectanceStack AssembleStack(const std::string& file, std::vector<BandPlanes> bands, PlaneF valid,
                               const FileConditions& conditions) {
  assert(!bands.empty());
  std::stable_sort(bands.begin(), bands.end(), [](const BandPlanes& a, const BandPlanes& b) {
    return a.band.wavelength_nm < b.band.wavelength_nm;
  });
  ReflectanceStack stack;
  for (const BandPlanes& band : bands) stack.bands.push_back(band.band);
  CheckBands(file, stack.bands);
  CheckSigmaCount(file, bands);
  for (BandPlanes& band : bands) {
    CheckReflectance(file, band.band, band.reflectance);
    CheckSigma(file, band.band, band.sigma);
    stack.reflectance.push_back(std::move(band.reflectance));
    if (!band.sigma.empty()) stack.sigma.push_back(std::move(band.sigma));
  }
  CheckNotEmpty(file, stack.reflectance);
  for (float& value : valid.values()) value = value > 0.5f ? 1.0f : 0.0f;
  stack.valid = std::move(valid);
  stack.pixel_size_mm = conditions.pixel_size_mm;
  stack.illumination = conditions.illumination;
  stack.tape = conditions.tape;
  stack.geometry = conditions.geometry;
  return stack;
}

FileConditions ConditionsOf(const ReflectanceStack& stack) {
  return {stack.pixel_size_mm, stack.illumination, stack.tape, stack.geometry};
}

ReflectanceStack ReadReflectanceStack(const std::filesystem::path& path) {
  CheckReadable(path);
  CheckExtension(path);
  return IsEnvi(path) ? ReadEnviStack(path) : ReadExrStack(path);
}

void WriteReflectanceStack(const std::filesystem::path& path, const ReflectanceStack& stack) {
  assert(!stack.bands.empty() && stack.bands.size() == stack.reflectance.size());
  assert(stack.sigma.empty() || stack.sigma.size() == stack.bands.size());
  CheckExtension(path);
  IsEnvi(path) ? WriteEnviStack(path, stack) : WriteExrStack(path, stack);
}

}  // namespace dermap
