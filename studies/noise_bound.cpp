// SPDX-License-Identifier: Apache-2.0
// Normal matrices of single pixels, inverted.
#include "studies/noise_bound.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fit/parameter_space.h"

namespace dermap {

double QuantileOrNaN(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double MedianOrNaN(std::vector<double> values) {
  return QuantileOrNaN(std::move(values), 0.5);
}

ParameterVector PixelNoiseBound(const ForwardModel& model, const ParameterMaps& truth,
                                const std::vector<PlaneF>& noise, std::size_t pixel) {
  const ParameterVector p = TableOne(PointAt(truth, pixel, model.tissue().junction_absorbance));
  Eigen::Matrix<double, kParameterCount, kParameterCount> normal;
  normal.setZero();
  for (int k = 0; k < kParameterCount; ++k) {
    const double range = kParameters[k].upper - kParameters[k].lower;
    normal(k, k) = 12.0 / (range * range);
  }
  for (int b = 0; b < model.band_count(); ++b) {
    const double sigma = noise[b].data()[pixel];
    if (!(sigma > 0.0)) continue;
    ParameterVector gradient;
    model.LocalReflectance(b, p, model.tissue().junction_absorbance, gradient);
    for (int j = 0; j < kParameterCount; ++j)
      for (int k = 0; k < kParameterCount; ++k) normal(j, k) += gradient[j] * gradient[k] / (sigma * sigma);
  }
  const auto covariance = normal.inverse().eval();
  ParameterVector bound;
  for (int k = 0; k < kParameterCount; ++k) bound[k] = std::sqrt(covariance(k, k));
  return bound;
}

ParameterVector NoiseBound(const ForwardModel& model, const ParameterMaps& truth,
                           const std::vector<PlaneF>& noise) {
  constexpr std::size_t kSamples = 250;
  const std::size_t step = std::max<std::size_t>(1, truth.planes[0].size() / kSamples);
  std::array<std::vector<double>, kParameterCount> sigmas;
  for (std::size_t i = 0; i < truth.planes[0].size(); i += step) {
    const ParameterVector bound = PixelNoiseBound(model, truth, noise, i);
    for (int k = 0; k < kParameterCount; ++k) sigmas[k].push_back(bound[k]);
  }
  ParameterVector bound{};
  for (int k = 0; k < kParameterCount; ++k) bound[k] = MedianOrNaN(std::move(sigmas[k]));
  return bound;
}

ParameterVector MedianErrors(const ParameterMaps& found, const ParameterMaps& truth,
                             const std::vector<char>& use) {
  ParameterVector errors{};
  for (int k = 0; k < kParameterCount; ++k) {
    std::vector<double> differences;
    for (std::size_t i = 0; i < truth.planes[k].size(); ++i)
      if (use.empty() || use[i])
        differences.push_back(std::abs(double(found.planes[k].data()[i]) - truth.planes[k].data()[i]));
    errors[k] = MedianOrNaN(std::move(differences));
  }
  return errors;
}

}  // namespace dermap
