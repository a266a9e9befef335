// SPDX-License-Identifier: Apache-2.0
// Makes light patterns and reads them from files.
#include "render/relight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "common/core/error.h"
#include "common/files/maps.h"
#include "common/files/picture.h"
#include "common/files/stack.h"

namespace dermap {
namespace {

constexpr std::string_view kForms =
    "uniform, stripes:PERIODmm (such as stripes:1.0mm), spot:DIAMETERmm or an EXR file";
constexpr double kMaxShapeDifference = 0.01;

// "1.5mm" or "1.5" to 1.5.
std::optional<double> ParseLength_mm(std::string_view text) {
  if (text.ends_with("mm")) text.remove_suffix(2);
  while (text.ends_with(' ')) text.remove_suffix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value > 0.0 && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// How much of [0, x] is lit by stripes of period 1 whose first half is lit.
double LitLength(double x) {
  return 0.5 * std::floor(x) + std::min(0.5, x - std::floor(x));
}

PlaneF Stripes(const LitPatch& patch, double period_mm) {
  PlaneF light(patch.width, patch.height);
  const double pixel = patch.pixel_size_mm / period_mm;
  for (int x = 0; x < patch.width; ++x) {
    const auto share = static_cast<float>((LitLength((x + 1) * pixel) - LitLength(x * pixel)) / pixel);
    for (int y = 0; y < patch.height; ++y) light(x, y) = share;
  }
  return light;
}

// Share of a pixel's area inside a circle about the patch's middle, by 16 x 16 points where the edge crosses
// it.
PlaneF Spot(const LitPatch& patch, double diameter_mm) {
  constexpr int kPoints = 16;
  PlaneF light(patch.width, patch.height);
  const double radius = 0.5 * diameter_mm / patch.pixel_size_mm;
  for (int y = 0; y < patch.height; ++y) {
    for (int x = 0; x < patch.width; ++x) {
      const double dx = x + 0.5 - 0.5 * patch.width, dy = y + 0.5 - 0.5 * patch.height;
      const double distance = std::hypot(dx, dy);
      if (std::abs(distance - radius) > 0.75) {  // more than half a pixel's diagonal
        light(x, y) = distance < radius ? 1.0f : 0.0f;
        continue;
      }
      int inside = 0;
      for (int i = 0; i < kPoints * kPoints; ++i) {
        const double px = dx + (i % kPoints + 0.5) / kPoints - 0.5;
        const double py = dy + (i / kPoints + 0.5) / kPoints - 0.5;
        inside += px * px + py * py < radius * radius;
      }
      light(x, y) = static_cast<float>(inside) / (kPoints * kPoints);
    }
  }
  return light;
}

void CheckLight(const std::string& path, const std::string& channel, const PlaneF& plane,
                const LitPatch& patch) {
  const auto bad = std::find_if(plane.values().begin(), plane.values().end(),
                                [](float value) { return !std::isfinite(value) || value < 0.0f; });
  if (bad != plane.values().end()) {
    throw InputError(
        fmt::format("{}: channel {} holds {} as light; light is a finite number from 0 up, 1 being as bright "
                    "as in a capture. Repair the picture.",
                    path, channel, *bad));
  }
  const double wanted = static_cast<double>(patch.width) / patch.height;
  const double found = static_cast<double>(plane.width()) / plane.height();
  if (std::abs(found / wanted - 1.0) > kMaxShapeDifference) {
    throw InputError(fmt::format(
        "{}: the light is {} x {} pixels, but the maps are {} x {}; crop it to the same shape (its "
        "size may differ).",
        path, plane.width(), plane.height(), patch.width, patch.height));
  }
}

using SpectralPlanes = std::map<double, const PlaneF*>;  // by wavelength, nm

SpectralPlanes SpectralChannels(const NamedPlanes& channels) {
  for (const char* prefix : {"light", "T"}) {
    SpectralPlanes planes;
    for (const auto& [name, plane] : channels) {
      if (const auto wavelength_nm = WavelengthOfChannel(name, prefix)) planes[*wavelength_nm] = &plane;
    }
    if (!planes.empty()) return planes;
  }
  return {};
}

// Linear between the two neighbours in wavelength, constant beyond the first and last.
PlaneF AtWavelength(const SpectralPlanes& planes, double wavelength_nm) {
  const auto above = planes.lower_bound(wavelength_nm);
  if (above == planes.begin()) return *above->second;
  const auto below = std::prev(above);
  if (above == planes.end()) return *below->second;
  const auto share = static_cast<float>((wavelength_nm - below->first) / (above->first - below->first));
  PlaneF result = *below->second;
  for (std::size_t i = 0; i < result.size(); ++i) {
    result.data()[i] += share * (above->second->data()[i] - result.data()[i]);
  }
  return result;
}

const std::pair<std::string, PlaneF>* GrayChannel(const NamedPlanes& channels) {
  if (channels.size() == 1) return &channels.front();
  for (const char* wanted : {"light", "Y", "L"}) {
    for (const auto& channel : channels) {
      if (channel.first == wanted) return &channel;
    }
  }
  return nullptr;
}

}  // namespace

LightPattern ReadLight(const std::string& path, const LitPatch& patch, std::span<const Band> bands) {
  assert(patch.width > 0 && patch.height > 0);
  const NamedPlanes channels = ReadPlanes(path);
  const std::string file = std::filesystem::path(path).filename().string();
  LightPattern light;
  const SpectralPlanes spectral = SpectralChannels(channels);
  if (!spectral.empty()) {
    for (const auto& [wavelength_nm, plane] : spectral) {
      CheckLight(path, fmt::format("at {:g} nm", wavelength_nm), *plane, patch);
    }
    for (const Band& band : bands) {
      const PlaneF plane = AtWavelength(spectral, band.wavelength_nm);
      light.planes.push_back(ResizeByArea(plane, patch.width, patch.height));
      if (band.wavelength_nm < spectral.begin()->first || band.wavelength_nm > spectral.rbegin()->first) {
        light.notes.push_back(
            fmt::format("{} says nothing about {:g} nm; the light of its nearest wavelength was taken.", file,
                        band.wavelength_nm));
      }
    }
    light.description = fmt::format("Light of {}, {} bands", file, spectral.size());
    return light;
  }
  const auto* gray = GrayChannel(channels);
  if (gray == nullptr) {
    throw InputError(fmt::format(
        "{}: found {} channels, none of them named light, Y or L nor like light.450,000000nm; save "
        "the light as one gray channel or one a wavelength.",
        path, channels.size()));
  }
  CheckLight(path, gray->first, gray->second, patch);
  light.planes.push_back(ResizeByArea(gray->second, patch.width, patch.height));
  light.description = fmt::format("Light of {}, the same in all bands", file);
  return light;
}

LightPattern MakeLight(const std::string& name, const LitPatch& patch, std::span<const Band> bands) {
  assert(patch.width > 0 && patch.height > 0 && patch.pixel_size_mm > 0.0);
  if (name == "uniform") return {{}, "Uniform light", {}};
  const auto colon = name.find(':');
  const std::string kind = name.substr(0, colon);
  if (colon != std::string::npos && (kind == "stripes" || kind == "spot")) {
    const auto length_mm = ParseLength_mm(std::string_view(name).substr(colon + 1));
    if (!length_mm) {
      throw InputError(
          fmt::format("The light '{}' has no length above 0 mm after the colon; write {}.", name, kForms));
    }
    if (kind == "spot") return {{Spot(patch, *length_mm)}, fmt::format("A spot of {:g} mm", *length_mm), {}};
    return {{Stripes(patch, *length_mm)}, fmt::format("Stripes of light, {:g} mm apart", *length_mm), {}};
  }
  if (std::filesystem::path(name).extension() == ".exr") return ReadLight(name, patch, bands);
  throw InputError(fmt::format("The light '{}' is unknown; write {}.", name, kForms));
}

}  // namespace dermap
