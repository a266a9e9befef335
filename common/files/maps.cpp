// SPDX-License-Identifier: Apache-2.0
// maps.exr and its relatives.
#include "common/files/maps.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/core/error.h"
#include "common/files/exr_file.h"
#include "common/files/spectral_attributes.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr const char* kJunction = "junction_absorbance";
constexpr const char* kWavelengths = "dermap:wavelengthsNm";
constexpr const char* kWidths = "dermap:fwhmNm";
constexpr const char* kPixelSize = "dermap:pixelSizeMm";

// Concentrations and absorbances: finite and not negative. Upper bounds are the fit's affair: a rendering may
// exceed them.
void CheckMap(const std::string& file, const std::string& name, const PlaneF& plane) {
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      const float value = plane(x, y);
      if (std::isfinite(value) && value >= 0.0f) continue;
      throw InputError(file + ": " + name + " is " + FormatNumber(static_cast<double>(value)) +
                       " at pixel (" + std::to_string(x) + ", " + std::to_string(y) +
                       "); expected finite values, 0 or more");
    }
  }
}

std::vector<Band> ReadBands(const std::string& file, const ExrImage& image) {
  std::vector<Band> bands;
  const auto found = image.lists.find(kWavelengths);
  if (found == image.lists.end()) {
    if (image.HasAttribute(kWavelengths)) {
      throw InputError(file + ": " + kWavelengths +
                       " is not a list of floats; expected the bands of the fit in nm");
    }
    return bands;
  }
  for (const float wavelength_nm : found->second) bands.push_back({DecimalOf(wavelength_nm), 0.0});
  ReadWidths(file, image, bands);
  CheckBands(file, bands);
  const bool ascending = std::is_sorted(bands.begin(), bands.end(), [](const Band& a, const Band& b) {
    return a.wavelength_nm < b.wavelength_nm;
  });
  if (!ascending)
    throw InputError(file + ": " + kWavelengths + " is not in ascending order; remedy: sort it");
  return bands;
}

// One gray plane, or one a band in the order of the bands.
std::vector<PlaneF> TakeJunction(const std::string& file, ExrImage& image, const std::vector<Band>& bands) {
  std::vector<PlaneF> gray;
  std::vector<std::pair<double, PlaneF>> spectral;
  for (auto& [name, plane] : image.planes) {
    if (!name.starts_with(kJunction)) continue;
    CheckMap(file, name, plane);
    if (name == kJunction) {
      gray.push_back(std::move(plane));
    } else if (const auto wavelength_nm = WavelengthOfChannel(name, kJunction)) {
      spectral.emplace_back(*wavelength_nm, std::move(plane));
    } else {
      throw InputError(file + ": the channel '" + Shorten(name, 60) + "' names no wavelength; expected " +
                       SpectralChannelName(kJunction, 450.0));
    }
  }
  if (spectral.empty()) return gray;
  std::sort(spectral.begin(), spectral.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  bool agrees = gray.empty() && spectral.size() == bands.size();
  // The attribute is float32, the channel's name is not: 2e-4 nm apart at 1000 nm is the same band.
  for (std::size_t i = 0; agrees && i < bands.size(); ++i) {
    agrees = std::abs(spectral[i].first - bands[i].wavelength_nm) < 1e-3;
  }
  if (!agrees) {
    throw InputError(file + ": the channels junction_absorbance.* do not agree with " + kWavelengths +
                     "; expected either one plane junction_absorbance or one for each band");
  }
  std::vector<PlaneF> planes;
  for (auto& [wavelength_nm, plane] : spectral) planes.push_back(std::move(plane));
  return planes;
}

}  // namespace

MapsFile ReadMaps(const std::filesystem::path& path) {
  const std::string file = path.string();
  ExrImage image = ReadExr(path, [](const std::string& name) {
    return ParameterFromName(name).has_value() || name.starts_with(kJunction);
  });
  MapsFile result;
  for (int i = 0; i < kParameterCount; ++i) {
    const std::string name(kParameters[i].name);
    const PlaneF* plane = image.Find(name);
    if (!plane) {
      throw InputError(file + " has no channel '" + name +
                       "' (its channels: " + Shorten(Join(image.channels, ", "), 100) +
                       "); expected maps with C_m, beta_m, C_he, C_bc, C_hd");
    }
    CheckMap(file, name, *plane);
    result.maps.planes[i] = *plane;
  }
  result.bands = ReadBands(file, image);
  result.maps.junction_absorbance = TakeJunction(file, image, result.bands);
  const FileConditions conditions = ReadConditions(file, image);
  result.pixel_size_mm = conditions.pixel_size_mm;
  result.illumination = conditions.illumination;
  result.tape = conditions.tape;
  result.geometry = conditions.geometry;
  return result;
}

void WriteMaps(const std::filesystem::path& path, const MapsFile& file) {
  const ParameterMaps& maps = file.maps;
  ExrImage image;
  image.width = maps.width();
  image.height = maps.height();
  for (int i = 0; i < kParameterCount; ++i) image.planes.emplace_back(kParameters[i].name, maps.planes[i]);
  const std::size_t junctions = maps.junction_absorbance.size();
  assert(junctions <= 1 || junctions == file.bands.size());
  if (junctions == 1) image.planes.emplace_back(kJunction, maps.junction_absorbance[0]);
  for (std::size_t i = 0; junctions > 1 && i < junctions; ++i) {
    image.planes.emplace_back(SpectralChannelName(kJunction, file.bands[i].wavelength_nm),
                              maps.junction_absorbance[i]);
  }
  WriteConditions({file.pixel_size_mm, file.illumination, file.tape, file.geometry}, image);
  for (const Band& band : file.bands) {
    image.lists[kWavelengths].push_back(static_cast<float>(band.wavelength_nm));
    image.lists[kWidths].push_back(static_cast<float>(band.fwhm_nm));
  }
  WriteExr(path, image);
}

NamedPlanes ReadPlanes(const std::filesystem::path& path) {
  ExrImage image = ReadExr(path, [](const std::string&) { return true; });
  return std::move(image.planes);
}

void WritePlanes(const std::filesystem::path& path, const NamedPlanes& planes,
                 std::optional<double> pixel_size_mm) {
  assert(!planes.empty());
  ExrImage image;
  image.width = planes[0].second.width();
  image.height = planes[0].second.height();
  image.planes = planes;
  if (pixel_size_mm) image.numbers[kPixelSize] = *pixel_size_mm;
  WriteExr(path, image);
}

}  // namespace dermap
