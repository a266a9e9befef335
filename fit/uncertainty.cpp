// SPDX-License-Identifier: Apache-2.0
// Covariances of single pixels, and what flags follow from them.
#include "fit/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr double kRangePrecision =
    1.0;                              // scaled units: the variance of a uniform distribution over the range
constexpr double kBoundShare = 1e-4;  // of the range: nearer than that is at the bound
constexpr double kNoise_sigma = 3.0;

struct ReflectanceRange {
  double darkest, brightest;
};

// What uniform skin can reflect in a band: the extremes over the corners of table 1's box (reflectance falls
// with every content and is monotonic in beta_m).
ReflectanceRange RangeOfModel(const ForwardModel& model, int band) {
  ReflectanceRange range{1e9, -1e9};
  for (int corner = 0; corner < (1 << kParameterCount); ++corner) {
    ParameterVector p;
    for (int i = 0; i < kParameterCount; ++i)
      p[i] = (corner >> i & 1) ? kParameters[i].upper : kParameters[i].lower;
    const double reflectance = model.LocalReflectance(band, p, model.tissue().junction_absorbance);
    range.darkest = std::min(range.darkest, reflectance);
    range.brightest = std::max(range.brightest, reflectance);
  }
  return range;
}

bool AtBound(const PatchProblem& problem, const SkinPoint& p) {
  for (Parameter parameter : problem.space().free()) {
    const ParameterInfo& info = InfoOf(parameter);
    const double near = kBoundShare * (info.upper - info.lower), value = p[static_cast<int>(parameter)];
    if (value < info.lower + near || value > info.upper - near) return true;
  }
  return false;
}

bool OutsideValidity(const FitData& data, const std::vector<ReflectanceRange>& ranges, std::size_t pixel) {
  for (int b = 0; b < data.band_count(); ++b) {
    if (!data.Has(b, pixel)) continue;
    const double measured = data.measured[b].data()[pixel];
    const double noise = kNoise_sigma * data.sigma[b].data()[pixel];
    if (measured > ranges[b].brightest + noise || measured < ranges[b].darkest - noise) return true;
  }
  return false;
}

bool NotIdentifiable(const ParameterSpace& space, const ParameterMaps& sigma, std::size_t pixel) {
  for (int j = 0; j < space.count(); ++j)
    if (!(sigma.Unknown(space.parameter(j)).data()[pixel] <= kIdentifiable * space.scale(j))) return true;
  return false;
}

}  // namespace

ParameterMaps StandardDeviations(const PatchProblem& problem, const FitState& state) {
  const FitData& data = problem.data();
  const ParameterSpace& space = problem.space();
  ParameterMaps sigma = problem.UniformMaps(SkinPoint{});
  ParallelFor(data.height(), [&](int y) {
    for (int x = 0; x < data.width(); ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * data.width() + x;
      FreeVector variance;
      variance.fill(1.0);  // a masked pixel: only the range is known
      if (data.fitted.data()[pixel]) {
        const SkinPoint p = problem.PointAt(state.maps, pixel);
        variance = InverseDiagonal(LocalSystem(problem, pixel, p, &state.predicted), kRangePrecision);
      }
      for (int j = 0; j < space.count(); ++j)
        sigma.Unknown(space.parameter(j))(x, y) = static_cast<float>(std::sqrt(variance[j]) * space.scale(j));
    }
  });
  return sigma;
}

ParameterMaps SigmaMaps(const PatchProblem& problem, const std::vector<PlaneF>& variance) {
  const ParameterSpace& space = problem.space();
  ParameterMaps sigma = problem.UniformMaps(SkinPoint{});
  for (int j = 0; j < space.count(); ++j) {
    PlaneF& plane = sigma.Unknown(space.parameter(j));
    for (std::size_t i = 0; i < plane.size(); ++i)
      plane.data()[i] = static_cast<float>(std::sqrt(variance[j].data()[i]) * space.scale(j));
  }
  return sigma;
}

void FlagUnexplained(const PatchProblem& problem, const std::vector<PlaneF>& noise_variance,
                     const ParameterMaps& sigma, Plane<std::uint32_t>& flags) {
  const ParameterSpace& space = problem.space();
  for (std::size_t j = 0; j < noise_variance.size(); ++j) {
    const PlaneF& widened = sigma.Unknown(space.parameter(static_cast<int>(j)));
    const double scale = space.scale(static_cast<int>(j));
    for (std::size_t i = 0; i < flags.size(); ++i)
      if (problem.data().fitted.data()[i] &&
          widened.data()[i] > kUnexplainedWidening * scale * std::sqrt(noise_variance[j].data()[i]))
        flags.data()[i] |= kFlagUnexplained;
  }
}

void FlagAll(const PatchProblem& problem, FitFlag flag, Plane<std::uint32_t>& flags) {
  for (std::size_t i = 0; i < flags.size(); ++i)
    if (problem.data().fitted.data()[i]) flags.data()[i] |= flag;
}

Plane<std::uint32_t> FlagsOf(const PatchProblem& problem, const FitState& state, const ParameterMaps& sigma) {
  const FitData& data = problem.data();
  std::vector<ReflectanceRange> ranges;
  for (int b = 0; b < data.band_count(); ++b) ranges.push_back(RangeOfModel(problem.model(), b));
  Plane<std::uint32_t> flags = data.flags;
  ParallelFor(data.height(), [&](int y) {
    for (int x = 0; x < data.width(); ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * data.width() + x;
      if (!data.fitted.data()[pixel]) continue;
      std::uint32_t& flag = flags.data()[pixel];
      const SkinPoint p = problem.PointAt(state.maps, pixel);
      int count = 0;
      for (int b = 0; b < data.band_count(); ++b) count += data.Has(b, pixel);
      if (AtBound(problem, p)) flag |= kFlagAtBound;
      if (state.misfit.chi2_map.data()[pixel] > kUnexplainedChi2 * count) flag |= kFlagNotConverged;
      if (NotIdentifiable(problem.space(), sigma, pixel)) flag |= kFlagNotIdentifiable;
      if (OutsideValidity(data, ranges, pixel)) flag |= kFlagOutsideValidity;
    }
  });
  return flags;
}

}  // namespace dermap
