// SPDX-License-Identifier: Apache-2.0
// TIFF by OpenCV, ENVI by our own reader.
#include "calibrate/import_stack.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "calibrate/statistics.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr std::size_t kMostPlanes = 4096;

std::string Extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

double DefaultScale(int depth) {
  switch (depth) {
    case CV_8U:
      return 1.0 / 255.0;
    case CV_16U:
      return 1.0 / 65535.0;
    default:
      return 1.0;
  }
}

// All planes of one TIFF: its pages, and within a page its channels in the file's order.
std::vector<PlaneF> ReadTiff(const std::filesystem::path& path, const std::optional<double>& scale) {
  std::vector<cv::Mat> pages;
  bool read = false;
  try {
    read = cv::imreadmulti(path.string(), pages, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    read = false;
  }
  if (!read || pages.empty()) {
    throw InputError(path.string() +
                     ": not a TIFF that can be read; expected pages of 8, 16 or 32 bits a value: "
                     "convert it with another program, or to ENVI");
  }
  std::vector<PlaneF> planes;
  for (const cv::Mat& page : pages) {
    const int channels = page.channels();
    cv::Mat values;
    page.convertTo(values, CV_32F, scale.value_or(DefaultScale(page.depth())));
    for (int c = 0; c < channels; ++c) {
      const int stored = channels == 3 || channels == 4 ? (c < 3 ? 2 - c : 3) : c;  // OpenCV turns RGB to BGR
      PlaneF plane(page.cols, page.rows);
      for (int y = 0; y < page.rows; ++y) {
        const auto* row = values.ptr<float>(y);
        for (int x = 0; x < page.cols; ++x) plane(x, y) = row[x * channels + stored];
      }
      planes.push_back(std::move(plane));
    }
    if (planes.size() > kMostPlanes)
      throw InputError(path.string() + ": more than 4096 planes; expected a stack");
  }
  return planes;
}

ReflectanceStack FromTiffs(const std::vector<std::filesystem::path>& inputs, const ImportOptions& options) {
  ReflectanceStack stack;
  for (const auto& path : inputs) {
    for (PlaneF& plane : ReadTiff(path, options.scale)) {
      if (!stack.reflectance.empty() && !plane.SameShape(stack.reflectance[0])) {
        throw InputError(path.string() + ": " + std::to_string(plane.width()) + "x" +
                         std::to_string(plane.height()) + " pixels, but the first plane has " +
                         std::to_string(stack.reflectance[0].width()) + "x" +
                         std::to_string(stack.reflectance[0].height()) + "; expected one shape throughout");
      }
      stack.reflectance.push_back(std::move(plane));
    }
  }
  if (options.wavelengths_nm.size() != stack.reflectance.size()) {
    throw InputError(inputs[0].string() + ": " + std::to_string(stack.reflectance.size()) + " planes, and " +
                     std::to_string(options.wavelengths_nm.size()) +
                     " wavelengths; expected one for each plane: --wavelengths-nm 450,500,...");
  }
  for (const double nm : options.wavelengths_nm) stack.bands.push_back({nm, 0.0});
  return stack;
}

ReflectanceStack FromEnvi(const std::filesystem::path& path, const ImportOptions& options) {
  ReflectanceStack stack = ReadReflectanceStack(path);
  if (!options.wavelengths_nm.empty()) {
    if (options.wavelengths_nm.size() != stack.bands.size()) {
      throw InputError(path.string() + ": " + std::to_string(stack.bands.size()) + " bands, and " +
                       std::to_string(options.wavelengths_nm.size()) +
                       " wavelengths; expected one for each band");
    }
    for (std::size_t i = 0; i < stack.bands.size(); ++i)
      stack.bands[i].wavelength_nm = options.wavelengths_nm[i];
  }
  if (options.scale) {
    for (auto* planes : {&stack.reflectance, &stack.sigma}) {
      for (PlaneF& plane : *planes) {
        for (float& v : plane.values()) v *= static_cast<float>(*options.scale);
      }
    }
  }
  return stack;
}

void SetWidths(const ImportOptions& options, ReflectanceStack& stack) {
  if (options.fwhm_nm.empty()) return;
  if (options.fwhm_nm.size() != 1 && options.fwhm_nm.size() != stack.bands.size()) {
    throw InputError("--fwhm-nm has " + std::to_string(options.fwhm_nm.size()) +
                     " numbers; expected one, or " + std::to_string(stack.bands.size()) + ", one a band");
  }
  for (std::size_t i = 0; i < stack.bands.size(); ++i)
    stack.bands[i].fwhm_nm = options.fwhm_nm[options.fwhm_nm.size() == 1 ? 0 : i];
}

void SortBands(ReflectanceStack& stack) {
  std::vector<std::size_t> order(stack.bands.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return stack.bands[a].wavelength_nm < stack.bands[b].wavelength_nm;
  });
  ReflectanceStack sorted = stack;
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted.bands[i] = stack.bands[order[i]];
    sorted.reflectance[i] = std::move(stack.reflectance[order[i]]);
    if (!stack.sigma.empty()) sorted.sigma[i] = std::move(stack.sigma[order[i]]);
    if (i > 0 && sorted.bands[i].wavelength_nm <= sorted.bands[i - 1].wavelength_nm)
      throw InputError("two bands at " + Short(sorted.bands[i].wavelength_nm) +
                       " nm; expected each wavelength once");
  }
  stack = std::move(sorted);
}

// Reflectance lies between 0 and about 1: values far outside are another quantity, or another scale.
void CheckRange(const ReflectanceStack& stack) {
  for (std::size_t b = 0; b < stack.bands.size(); ++b) {
    std::vector<float> finite;
    for (const float v : stack.reflectance[b].values()) {
      if (std::isfinite(v)) finite.push_back(v);
    }
    const double median = finite.empty() ? std::nan("") : Median(std::move(finite));
    if (median >= -0.05 && median <= 1.5) continue;
    throw InputError(
        "the band at " + Short(stack.bands[b].wavelength_nm) + " nm has a median of " + Short(median) +
        "; expected reflectance between 0 and about 1: give --scale, the reflectance of one unit");
  }
}

}  // namespace

ReflectanceStack ImportStack(const std::vector<std::filesystem::path>& inputs, const ImportOptions& options) {
  if (inputs.empty()) throw InputError("nothing to import; expected TIFF files or an ENVI header");
  for (const double nm : options.wavelengths_nm) {
    if (!(nm >= 200.0 && nm <= 3000.0))
      throw InputError("--wavelengths-nm holds " + Short(nm) + "; expected nanometres from 200 to 3000");
  }
  const bool tiff = Extension(inputs[0]) == ".tif" || Extension(inputs[0]) == ".tiff";
  if (!tiff && inputs.size() > 1)
    throw InputError(inputs[1].string() +
                     ": only TIFF stacks may consist of several files; expected one ENVI header");
  ReflectanceStack stack = tiff ? FromTiffs(inputs, options) : FromEnvi(inputs[0], options);
  SetWidths(options, stack);
  if (options.pixel_size_mm) stack.pixel_size_mm = *options.pixel_size_mm;
  if (options.illumination) stack.illumination = *options.illumination;
  if (options.tape) stack.tape = *options.tape;
  if (options.geometry) stack.geometry = *options.geometry;
  SortBands(stack);
  CheckRange(stack);
  if (options.relative_sigma) {
    stack.sigma.clear();
    for (const PlaneF& plane : stack.reflectance) {
      PlaneF sigma = plane;
      for (float& v : sigma.values())
        v = std::max(1e-5f, std::abs(v)) * static_cast<float>(*options.relative_sigma);
      stack.sigma.push_back(std::move(sigma));
    }
  }
  return stack;
}

}  // namespace dermap
