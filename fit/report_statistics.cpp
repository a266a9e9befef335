// SPDX-License-Identifier: Apache-2.0
// Statistics over maps that may miss pixels.
#include "fit/report_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/files/picture.h"

namespace dermap {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool Masked(const Plane<std::uint32_t>& flags, std::size_t pixel) {
  return !flags.empty() && (flags.data()[pixel] & kFlagSaturated) != 0;
}

std::optional<PlaneF> AtSizeOf(const PlaneF& truth, const PlaneF& map) {
  if (truth.empty()) return std::nullopt;
  return ResizeByArea(truth, map.width(), map.height());
}

// The smallest (sign = 1) or largest (sign = -1) 3 x 3 mean of `plane` inside the border.
std::optional<std::pair<int, int>> Extreme(const PlaneF& plane, const Plane<std::uint32_t>& flags,
                                           double sign) {
  const int border = 1 + std::min(plane.width(), plane.height()) / 20;
  std::optional<std::pair<int, int>> where;
  double best = std::numeric_limits<double>::infinity();
  for (int y = border; y < plane.height() - border; ++y) {
    for (int x = border; x < plane.width() - border; ++x) {
      if (Masked(flags, static_cast<std::size_t>(y) * plane.width() + x)) continue;
      const double value = sign * MeanAround(plane, x, y);
      if (value < best) {
        best = value;
        where = {x, y};
      }
    }
  }
  return where;
}

}  // namespace

std::vector<ReportedMap> ReportedMaps(const FitResult& fit, const MapsFile* truth) {
  std::vector<ReportedMap> maps;
  for (int i = 0; i < kParameterCount; ++i) {
    const ParameterInfo& info = kParameters[i];
    if (fit.maps.planes[i].empty()) continue;
    ReportedMap& map = maps.emplace_back();
    map.name = info.name;
    map.description = info.description;
    map.unit = info.unit;
    map.free =
        std::count(fit.free_parameters.begin(), fit.free_parameters.end(), static_cast<Parameter>(i)) > 0;
    map.value = &fit.maps.planes[i];
    if (fit.sigma.planes[i].SameShape(*map.value)) map.sigma = &fit.sigma.planes[i];
    if (truth != nullptr) map.truth = AtSizeOf(truth->maps.planes[i], *map.value);
  }
  const auto& junction = fit.maps.junction_absorbance;
  for (std::size_t i = 0; i < junction.size(); ++i) {
    ReportedMap& map = maps.emplace_back();
    map.name = "junction_absorbance";
    if (junction.size() > 1 && i < fit.bands.size()) {
      map.name += " at " + FormatValue(fit.bands[i].wavelength_nm, 4) + " nm";
    }
    map.description = "absorber between the layers (tattoo)";
    map.unit = "absorbance P, A = exp(-P)";
    map.free = true;
    map.value = &junction[i];
    const auto& sigma = fit.sigma.junction_absorbance;
    if (i < sigma.size() && sigma[i].SameShape(junction[i])) map.sigma = &sigma[i];
    if (truth != nullptr && truth->maps.junction_absorbance.size() == junction.size()) {
      map.truth = AtSizeOf(truth->maps.junction_absorbance[i], junction[i]);
    }
  }
  return maps;
}

double QuantileOf(std::span<const float> values, double share) {
  std::vector<float> finite;
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite),
               [](float v) { return std::isfinite(v); });
  if (finite.empty()) return kNan;
  const auto rank = static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(finite.size() - 1)));
  std::nth_element(finite.begin(), finite.begin() + rank, finite.end());
  return finite[rank];
}

TruthError CompareToTruth(const ReportedMap& map, const Plane<std::uint32_t>& flags) {
  std::vector<float> absolute, relative, signed_relative;
  int within_1 = 0, within_2 = 0, with_sigma = 0;
  for (std::size_t i = 0; i < map.value->size(); ++i) {
    const float value = map.value->data()[i];
    const float truth = map.truth->data()[i];
    if (Masked(flags, i) || !std::isfinite(value) || !std::isfinite(truth)) continue;
    const float error = value - truth;
    absolute.push_back(std::abs(error));
    if (truth != 0.0f) {
      relative.push_back(std::abs(error / truth));
      signed_relative.push_back(error / truth);
    }
    const float sigma = map.sigma != nullptr ? map.sigma->data()[i] : 0.0f;
    if (!(sigma > 0.0f)) continue;
    ++with_sigma;
    within_1 += std::abs(error) <= sigma;
    within_2 += std::abs(error) <= 2.0f * sigma;
  }
  TruthError result;
  result.pixels = static_cast<int>(absolute.size());
  result.median_absolute = QuantileOf(absolute, 0.5);
  result.median_relative = QuantileOf(relative, 0.5);
  result.percentile_90_relative = QuantileOf(relative, 0.9);
  result.bias_relative = QuantileOf(signed_relative, 0.5);
  result.share_within_1_sigma = with_sigma > 0 ? static_cast<double>(within_1) / with_sigma : kNan;
  result.share_within_2_sigma = with_sigma > 0 ? static_cast<double>(within_2) / with_sigma : kNan;
  return result;
}

std::vector<NamedPoint> NamedPoints(const FitResult& fit) {
  struct Wish {
    const char* name;
    const PlaneF& plane;
    double sign;
  };
  const std::vector<Wish> wishes{{"least melanin", fit.maps[Parameter::kC_m], 1.0},
                                 {"most melanin", fit.maps[Parameter::kC_m], -1.0},
                                 {"most blood in the dermis", fit.maps[Parameter::kC_hd], -1.0},
                                 {"worst fit", fit.chi2_map, -1.0}};
  std::vector<NamedPoint> points;
  for (const Wish& wish : wishes) {
    const auto where = Extreme(wish.plane, fit.flags, wish.sign);
    if (!where) continue;
    const auto [x, y] = *where;
    points.push_back({static_cast<char>('A' + points.size()), wish.name, x, y});
  }
  return points;
}

double MeanAround(const PlaneF& plane, int x, int y) {
  double sum = 0.0;
  int count = 0;
  for (int v = std::max(0, y - 1); v <= std::min(plane.height() - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(plane.width() - 1, x + 1); ++u) {
      if (!std::isfinite(plane(u, v))) continue;
      sum += plane(u, v);
      ++count;
    }
  }
  return count > 0 ? sum / count : kNan;
}

double MeanOf(const PlaneF& plane) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const float value : plane.values()) {
    if (!std::isfinite(value)) continue;
    sum += value;
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : kNan;
}

PlaneF WhereFinite(const PlaneF& plane, const PlaneF& reference) {
  PlaneF result = plane;
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (!std::isfinite(reference.data()[i])) result.data()[i] = static_cast<float>(kNan);
  }
  return result;
}

PlaneF WithoutMasked(const PlaneF& plane, const Plane<std::uint32_t>& flags) {
  PlaneF result = plane;
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (Masked(flags, i)) result.data()[i] = static_cast<float>(kNan);
  }
  return result;
}

}  // namespace dermap
