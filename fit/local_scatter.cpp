// SPDX-License-Identifier: Apache-2.0
// Scatter around each pixel, against chance.
#include "fit/local_scatter.h"

#include <cmath>

#include "common/core/parallel.h"
#include "fit/resample.h"
#include "fit/window_sums.h"

namespace dermap {
namespace {

constexpr int kReach = 3;              // pixels to every side
constexpr double kChance_sigma = 3.0;  // standard deviations of a mean of squares that chance may take

}  // namespace

void WidenByLocalScatter(const PatchProblem& problem, const Misfit& misfit, double expected,
                         ParameterMaps& sigma) {
  const FitData& data = problem.data();
  const int width = data.width(), height = data.height();
  PlaneF chi2(width, height), counts(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
      int count = 0;
      for (int b = 0; b < data.band_count(); ++b) count += data.Has(b, pixel);
      if (!data.fitted.data()[pixel]) count = 0;
      counts(x, y) = static_cast<float>(count);
      chi2(x, y) = count > 0 ? misfit.chi2_map.data()[pixel] : 0.0f;
    }
  const PlaneF chi2_around = SumsAround(chi2, kReach), counts_around = SumsAround(counts, kReach);
  const double shared = MeanNoiseInflation(data, 2.0 * kReach + 1.0);  // fewer squares are independent
  ParallelFor(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const double count = counts_around(x, y);
      if (count < 1.0 || !data.fitted(x, y)) continue;
      const double scatter = chi2_around(x, y) / (count * expected);
      const double chance = 1.0 + kChance_sigma * std::sqrt(2.0 * shared / count);
      if (scatter <= chance) continue;
      const auto factor = static_cast<float>(std::sqrt(scatter / chance));
      for (const Parameter p : problem.space().free()) sigma.Unknown(p)(x, y) *= factor;
    }
  });
}

}  // namespace dermap
