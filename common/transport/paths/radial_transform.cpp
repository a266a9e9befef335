// SPDX-License-Identifier: Apache-2.0
// Resampling of tabulated transforms.
#include "common/transport/paths/radial_transform.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "common/optics/profile_table.h"

namespace dermap {
namespace {

constexpr int kSamples = 1024;
constexpr double kTurn_per_mm = 0.1;  // samples are spaced like k below, like log k above
constexpr double kLast_per_mm = 2000.0;

double Coordinate(double k_per_mm) {
  return std::asinh(k_per_mm / kTurn_per_mm);
}

// Lagrange's cubic through four of the tabulated values, the same for every kernel.
struct Resampling {
  std::array<int, kSamples + 1> first;
  std::array<std::array<float, 4>, kSamples + 1> weights;
  int beyond = kSamples + 1;  // samples from here on lie beyond the table
  std::array<float, kSamples + 1> fall;

  Resampling() {
    std::vector<double> x;
    for (const double k : TableFrequencies_per_mm()) x.push_back(Coordinate(k));
    const double step = Coordinate(kLast_per_mm) / (kSamples - 1);
    for (int i = 0; i <= kSamples; ++i) {
      const double at = i * step;
      if (at > x.back()) {
        beyond = std::min(beyond, i);
        fall[i] = static_cast<float>(std::sinh(x.back()) / std::sinh(at));
        continue;
      }
      const int above = static_cast<int>(std::upper_bound(x.begin(), x.end(), at) - x.begin());
      first[i] = std::clamp(above - 2, 0, static_cast<int>(x.size()) - 4);
      for (int a = 0; a < 4; ++a) {
        double weight = 1.0;
        for (int b = 0; b < 4; ++b)
          if (b != a) weight *= (at - x[first[i] + b]) / (x[first[i] + a] - x[first[i] + b]);
        weights[i][a] = static_cast<float>(weight);
      }
    }
  }
};

const Resampling& TheResampling() {
  static const Resampling resampling;
  return resampling;
}

}  // namespace

RadialTransform::RadialTransform(std::span<const float> values) {
  assert(values.size() == TableFrequencies_per_mm().size());
  const Resampling& r = TheResampling();
  samples_.resize(kSamples + 1);
  for (int i = 0; i <= kSamples; ++i) {
    if (i >= r.beyond) {
      samples_[i] = values.back() * r.fall[i];
      continue;
    }
    const float* v = values.data() + r.first[i];
    samples_[i] =
        r.weights[i][0] * v[0] + r.weights[i][1] * v[1] + r.weights[i][2] * v[2] + r.weights[i][3] * v[3];
  }
}

RadialTransform::Position RadialTransform::PositionOf(double k_per_mm) noexcept {
  static const double scale = (kSamples - 1) / Coordinate(kLast_per_mm);
  const double position = std::min(Coordinate(k_per_mm) * scale, kSamples - 1.0);
  const int index = static_cast<int>(position);
  return {index, static_cast<float>(position - index)};
}

}  // namespace dermap
