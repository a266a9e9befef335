// SPDX-License-Identifier: Apache-2.0
// Sums over squares of pixels.
#include "fit/local_scatter.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"
#include "fit/resample.h"

namespace dermap {
namespace {

constexpr int kReach = 3;              // pixels to every side
constexpr double kChance_sigma = 3.0;  // standard deviations of a mean of squares that chance may take

// Sums of a plane over all pixels above and left of a corner.
class SumTable {
 public:
  SumTable(int width, int height)
      : width_(width + 1), sums_(static_cast<std::size_t>(width_) * (height + 1)) {}
  void Set(int x, int y, double value) { At(x + 1, y + 1) = value; }
  void Accumulate() {
    for (std::size_t i = width_; i < sums_.size(); ++i)
      if (i % width_ != 0) sums_[i] += sums_[i - 1] + sums_[i - width_] - sums_[i - width_ - 1];
  }
  // [left, right) x [top, bottom)
  double Of(int left, int top, int right, int bottom) const {
    return At(right, bottom) - At(left, bottom) - At(right, top) + At(left, top);
  }

 private:
  std::size_t width_;
  std::vector<double> sums_;
  double& At(int x, int y) { return sums_[static_cast<std::size_t>(y) * width_ + x]; }
  double At(int x, int y) const { return sums_[static_cast<std::size_t>(y) * width_ + x]; }
};

}  // namespace

void WidenByLocalScatter(const PatchProblem& problem, const Misfit& misfit, double expected,
                         ParameterMaps& sigma) {
  const FitData& data = problem.data();
  const int width = data.width(), height = data.height();
  SumTable chi2(width, height), counts(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
      int count = 0;
      for (int b = 0; b < data.band_count(); ++b) count += data.Has(b, pixel);
      if (!data.fitted.data()[pixel]) count = 0;
      counts.Set(x, y, count);
      chi2.Set(x, y, count > 0 ? misfit.chi2_map.data()[pixel] : 0.0);
    }
  chi2.Accumulate();
  counts.Accumulate();
  const double shared = MeanNoiseInflation(data, 2.0 * kReach + 1.0);  // fewer squares are independent
  ParallelFor(height, [&](int y) {
    const int top = std::max(y - kReach, 0), bottom = std::min(y + kReach + 1, height);
    for (int x = 0; x < width; ++x) {
      const int left = std::max(x - kReach, 0), right = std::min(x + kReach + 1, width);
      const double count = counts.Of(left, top, right, bottom);
      if (count < 1.0 || !data.fitted(x, y)) continue;
      const double scatter = chi2.Of(left, top, right, bottom) / (count * expected);
      const double chance = 1.0 + kChance_sigma * std::sqrt(2.0 * shared / count);
      if (scatter <= chance) continue;
      const auto factor = static_cast<float>(std::sqrt(scatter / chance));
      for (const Parameter p : problem.space().free()) sigma.Unknown(p)(x, y) *= factor;
    }
  });
}

}  // namespace dermap
