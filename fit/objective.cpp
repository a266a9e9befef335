// SPDX-License-Identifier: Apache-2.0
// Sums of squared residuals, in double and always in the same order.
#include "fit/objective.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace dermap {

Misfit Evaluate(const FitData& data, const std::vector<PlaneF>& predicted) {
  assert(predicted.size() == data.measured.size());
  Misfit misfit;
  misfit.chi2_map = Plane<double>(data.width(), data.height());
  misfit.adapted_share = AdaptedShare(data.conditions.pixel_size_mm);
  double square_sum = 0.0;
  for (int b = 0; b < data.band_count(); ++b) {
    double band_sum = 0.0;
    std::size_t band_count = 0;
    for (std::size_t i = 0; i < data.fitted.size(); ++i) {
      if (!data.fitted.data()[i] || !data.Has(b, i)) continue;
      const double residual = static_cast<double>(data.measured[b].data()[i]) - predicted[b].data()[i];
      const double in_sigma = residual / data.sigma[b].data()[i];
      misfit.chi2_map.data()[i] += in_sigma * in_sigma;
      band_sum += residual * residual;
      ++band_count;
    }
    misfit.rms_per_band.push_back(band_count > 0 ? std::sqrt(band_sum / static_cast<double>(band_count))
                                                 : 0.0);
    square_sum += band_sum;
    misfit.data_count += band_count;
  }
  for (double value : misfit.chi2_map.values()) misfit.chi2 += value;
  for (std::uint8_t fitted : data.fitted.values()) misfit.pixel_count += fitted != 0;
  if (misfit.data_count > 0) misfit.rms = std::sqrt(square_sum / static_cast<double>(misfit.data_count));
  return misfit;
}

double AdaptedShare(double pixel_size_mm) {
  return std::clamp(0.75 * std::pow(pixel_size_mm / 0.234, 0.55), 0.2, 0.8);
}

double Misfit::DegreesOfFreedom(int free_count) const {
  const double adapted = adapted_share * free_count * static_cast<double>(pixel_count);
  return std::max(static_cast<double>(data_count) - adapted, 1.0);
}

std::vector<PlaneF> Residual(const FitData& data, const std::vector<PlaneF>& predicted) {
  std::vector<PlaneF> residual = data.measured;  // NaN stays NaN
  for (std::size_t b = 0; b < residual.size(); ++b)
    for (std::size_t i = 0; i < residual[b].size(); ++i) residual[b].data()[i] -= predicted[b].data()[i];
  return residual;
}

LogResidual LogResidualOf(double measured, double sigma, double predicted) noexcept {
  constexpr double kDarkest = 1e-7, kNear = 0.2, kNear_sigma = 4.0;
  const double near = std::max(kNear, kNear_sigma * sigma / std::max(measured, sigma));
  const double p = std::max(predicted, kDarkest), ratio = measured / p;
  if (std::abs(ratio - 1.0) <= near) return {(measured - p) / sigma, p / sigma};
  const double edge = ratio > 1.0 ? 1.0 + near : 1.0 - near;  // ratio where the logarithm begins
  if (edge <= 0.0) return {(measured - p) / sigma, p / sigma};
  const double weight = std::max(measured, sigma) / sigma;
  return {weight * ((edge - 1.0) / edge + std::log(std::max(ratio, kDarkest) / edge)), weight};
}

}  // namespace dermap
