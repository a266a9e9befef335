// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt a pixel, started from the pixel before.
#include "fit/local_start.h"

#include <algorithm>

#include "common/core/parallel.h"
#include "fit/resample.h"

namespace dermap {
namespace {

constexpr int kMaxIterations = 40;
constexpr double kPriorPrecision = 1.0;  // scaled units: the variance of the range of table 1

struct LocalFit {
  PixelSystem system;
  double objective;
};

// Data and prior at p.
LocalFit FitAt(const PatchProblem& problem, std::size_t pixel, const SkinPoint& p) {
  const ParameterSpace& space = problem.space();
  LocalFit fit;
  fit.system = LocalSystem(problem, pixel, p, nullptr, &fit.objective);
  const FreeVector position = space.FromParameters(p);
  for (int j = 0; j < space.count(); ++j) {
    fit.system.AddPrior(j, kPriorPrecision, space.mean()[j], position[j]);
    const double off = position[j] - space.mean()[j];
    fit.objective += kPriorPrecision * off * off;
  }
  return fit;
}

}  // namespace

int InvertPixel(const PatchProblem& problem, std::size_t pixel, SkinPoint& p) {
  const ParameterSpace& space = problem.space();
  LocalFit fit = FitAt(problem, pixel, p);
  double damping = 1e-3;  // share of the mean of the diagonal
  for (int iteration = 1; iteration <= kMaxIterations; ++iteration) {
    const FreeVector position = space.FromParameters(p);
    const FreeVector step = BoundedStep(fit.system, damping * fit.system.Trace() / space.count(), position,
                                        space.lower(), space.upper());
    SkinPoint trial = p;
    FreeVector target{};
    for (int j = 0; j < space.count(); ++j) target[j] = position[j] + step[j];
    space.ToParameters(target, trial);
    LocalFit next = FitAt(problem, pixel, trial);
    if (next.objective <= fit.objective) {
      const double gain = fit.objective - next.objective;
      p = trial;
      fit = next;
      damping = std::max(damping * 0.1, 1e-9);
      if (gain <= 1e-4 * fit.objective + 1e-9) return iteration;
    } else {
      damping *= 8.0;
      if (damping > 1e6) return iteration;
    }
  }
  return kMaxIterations;
}

ParameterMaps InvertLocally(const PatchProblem& problem, const ParameterVector& fixed) {
  const FitData& data = problem.data();
  const SkinPoint start = PointOf(fixed, problem.model().tissue().junction_absorbance);
  ParameterMaps maps = problem.UniformMaps(start);
  ParallelFor(data.height(), [&](int y) {
    SkinPoint p = start;
    for (int x = 0; x < data.width(); ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * data.width() + x;
      if (!data.fitted.data()[pixel]) continue;
      InvertPixel(problem, pixel, p);
      SetPointAt(maps, pixel, p);
    }
  });
  MaskedFill(data.fitted).Apply(maps);
  return maps;
}

ParameterMaps InvertAverages(const PatchProblem& problem, const ParameterVector& fixed, int size) {
  const FitData reduced = ReduceData(problem.data(), size, problem.space().count());
  const PatchProblem small(reduced, problem.model(), problem.space());
  return ResizeLinear(InvertLocally(small, fixed), problem.data().width(), problem.data().height());
}

}  // namespace dermap
