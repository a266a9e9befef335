// SPDX-License-Identifier: Apache-2.0
// Solves the layers of the table one by one and puts them together (discrete ordinates, plane_skin.h).
#include "fit/spectra/skin_totals.h"

#include <cmath>
#include <mutex>
#include <vector>

#include "common/core/parallel.h"
#include "common/optics/plane_skin.h"

namespace dermap {

const std::array<GridAxis, 3>& SkinTotals::Axes() {
  static const std::array<GridAxis, 3> axes{GridAxis{std::log(0.02), std::log(30.0), 24},
                                            GridAxis{std::log(5e-4), std::log(30.0), 42},
                                            GridAxis{std::log(5e-4), std::log(10.0), 25}};
  return axes;
}

SkinTotals::SkinTotals(const TissueConfig& config, const ProgressFunction& progress) {
  const GridAxis thickness = Axes()[0], upper = Axes()[1], lower = Axes()[2];
  const PlaneSkin skin(config);
  std::vector<LightOperators> dermis(lower.count);
  ParallelFor(lower.count, [&](int k) { dermis[k] = skin.Dermis(std::exp(lower.At(k)), 1.0); });
  std::vector<double> log_reflectance(static_cast<std::size_t>(thickness.count) * upper.count * lower.count);
  std::mutex drawing;
  int done = 0;
  ParallelFor(thickness.count * upper.count, [&](int row) {
    const double mu_s_d = std::exp(thickness.At(row / upper.count)),
                 ratio = std::exp(upper.At(row % upper.count));
    const LightOperators epidermis = skin.Epidermis(ratio, 1.0, mu_s_d);
    for (int k = 0; k < lower.count; ++k) {
      log_reflectance[static_cast<std::size_t>(row) * lower.count + k] =
          std::log(skin.TwoLayers(epidermis, dermis[k], config.junction_absorbance).reflectance);
    }
    const std::lock_guard lock(drawing);
    ++done;
    if (progress) progress(static_cast<double>(done) / (thickness.count * upper.count));
  });
  grid_ = Grid3(Axes(), std::move(log_reflectance), 6);
}

}  // namespace dermap
