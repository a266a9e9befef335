// SPDX-License-Identifier: Apache-2.0
// Area averages with masks and noise, and linear interpolation.
#include "fit/resample.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace dermap {
namespace {

struct Overlap {
  int source;
  double share;  // of a source pixel's length
};

// For each new pixel the old ones that it covers, along one axis; `factor` old pixels a new one.
std::vector<std::vector<Overlap>> Overlaps(int old_count, int new_count, double factor) {
  std::vector<std::vector<Overlap>> overlaps(new_count);
  for (int i = 0; i < new_count; ++i) {
    const double begin = i * factor, end = (i + 1) * factor;
    for (int s = static_cast<int>(begin); s < old_count && s < end; ++s) {
      const double share = std::min(end, s + 1.0) - std::max(begin, static_cast<double>(s));
      if (share > 1e-9) overlaps[i].push_back({s, share});
    }
  }
  return overlaps;
}

double CorrelationAt(const std::vector<float>& lags, int distance) {
  const int lag = std::abs(distance);
  if (lag == 0) return 1.0;
  return lag <= static_cast<int>(lags.size()) ? lags[lag - 1] : 0.0;
}

// How noise that is correlated along one axis averages into pixels of `factor` old ones.
struct AveragedNoise {
  double inflation = 1.0;   // variance of the mean over what it were without correlation
  std::vector<float> lags;  // correlation of the new pixels 1, 2, ... apart
};

AveragedNoise AverageNoise(const std::vector<float>& lags, double factor) {
  if (lags.empty()) return {};
  const int reach = static_cast<int>(lags.size());
  const int apart = std::max(1, static_cast<int>(std::ceil(reach / factor)));
  const auto pixels = Overlaps(static_cast<int>(std::ceil((apart + 1) * factor)), apart + 1, factor);
  const auto covariance = [&](int i, int j) {
    double sum = 0.0;
    for (const Overlap& a : pixels[i])
      for (const Overlap& b : pixels[j]) sum += a.share * b.share * CorrelationAt(lags, a.source - b.source);
    return sum;
  };
  double independent = 0.0;
  for (const Overlap& a : pixels[0]) independent += a.share * a.share;
  AveragedNoise noise{covariance(0, 0) / independent, {}};
  for (int lag = 1; lag <= apart; ++lag)
    noise.lags.push_back(static_cast<float>(covariance(0, lag) / covariance(0, 0)));
  return noise;
}

// `inflation`: of the variance of the mean, by the correlation of the noise.
void ReduceBand(const PlaneF& measured, const PlaneF& sigma, double factor, double inflation, PlaneF& mean,
                PlaneF& mean_sigma) {
  const auto columns = Overlaps(measured.width(), mean.width(), factor);
  const auto rows = Overlaps(measured.height(), mean.height(), factor);
  for (int y = 0; y < mean.height(); ++y) {
    for (int x = 0; x < mean.width(); ++x) {
      double weight = 0.0, sum = 0.0, variance = 0.0;
      for (const Overlap& row : rows[y]) {
        for (const Overlap& column : columns[x]) {
          const double value = measured(column.source, row.source);
          if (!std::isfinite(value)) continue;
          const double share = row.share * column.share, noise = share * sigma(column.source, row.source);
          weight += share;
          sum += share * value;
          variance += noise * noise;
        }
      }
      if (weight < 0.5 * factor * factor) continue;
      mean(x, y) = static_cast<float>(sum / weight);
      mean_sigma(x, y) = static_cast<float>(std::sqrt(variance * inflation) / weight);
    }
  }
}

}  // namespace

FitData ReduceData(const FitData& data, int size, int free_count) {
  const int longer = std::max(data.width(), data.height());
  if (size <= 0 || size >= longer) return data;
  const double factor = static_cast<double>(longer) / size;
  const int width = std::max(1, static_cast<int>(std::lround(data.width() / factor)));
  const int height = std::max(1, static_cast<int>(std::lround(data.height() / factor)));
  FitData reduced;
  reduced.bands = data.bands;
  reduced.conditions = data.conditions;
  reduced.shared_error = data.shared_error;
  reduced.shared_error_allowance = data.shared_error_allowance;
  reduced.conditions.pixel_size_mm *= factor;
  const PlaneF missing(width, height, std::numeric_limits<float>::quiet_NaN());
  reduced.measured.assign(data.bands.size(), missing);
  reduced.sigma = reduced.measured;
  const AveragedNoise along_x = AverageNoise(data.noise_correlation_x, factor);
  const AveragedNoise along_y = AverageNoise(data.noise_correlation_y, factor);
  reduced.noise_correlation_x = along_x.lags;
  reduced.noise_correlation_y = along_y.lags;
  const double inflation = std::max(0.0, along_x.inflation) * std::max(0.0, along_y.inflation);
  for (int b = 0; b < data.band_count(); ++b)
    ReduceBand(data.measured[b], data.sigma[b], factor, inflation, reduced.measured[b], reduced.sigma[b]);
  reduced.flags = Plane<std::uint32_t>(width, height);
  MarkFitted(reduced, free_count);
  return reduced;
}

void AddRelativeError(FitData& data, double share) {
  for (int b = 0; b < data.band_count(); ++b) {
    for (std::size_t i = 0; i < data.measured[b].size(); ++i) {
      float& sigma = data.sigma[b].data()[i];
      sigma = static_cast<float>(std::hypot(sigma, share * data.measured[b].data()[i]));
    }
  }
}

double MeanNoiseInflation(const FitData& data, double side) {
  return AverageNoise(data.noise_correlation_x, side).inflation *
         AverageNoise(data.noise_correlation_y, side).inflation;
}

PlaneF ResizeLinear(const PlaneF& plane, int width, int height) {
  PlaneF out(width, height);
  const double step_x = static_cast<double>(plane.width()) / width;
  const double step_y = static_cast<double>(plane.height()) / height;
  for (int y = 0; y < height; ++y) {
    const double sy = std::clamp((y + 0.5) * step_y - 0.5, 0.0, plane.height() - 1.0);
    const int y0 = static_cast<int>(sy), y1 = std::min(y0 + 1, plane.height() - 1);
    const double fy = sy - y0;
    for (int x = 0; x < width; ++x) {
      const double sx = std::clamp((x + 0.5) * step_x - 0.5, 0.0, plane.width() - 1.0);
      const int x0 = static_cast<int>(sx), x1 = std::min(x0 + 1, plane.width() - 1);
      const double fx = sx - x0;
      const double top = plane(x0, y0) + fx * (plane(x1, y0) - plane(x0, y0));
      const double bottom = plane(x0, y1) + fx * (plane(x1, y1) - plane(x0, y1));
      out(x, y) = static_cast<float>(top + fy * (bottom - top));
    }
  }
  return out;
}

ParameterMaps ResizeLinear(const ParameterMaps& maps, int width, int height) {
  ParameterMaps out;
  for (int i = 0; i < kParameterCount; ++i) out.planes[i] = ResizeLinear(maps.planes[i], width, height);
  for (const PlaneF& plane : maps.junction_absorbance)
    out.junction_absorbance.push_back(ResizeLinear(plane, width, height));
  return out;
}

}  // namespace dermap
