// SPDX-License-Identifier: Apache-2.0
// Starts: average, local, random, resumed.
#include "fit/start_maps.h"

#include <random>

#include "fit/local_start.h"

namespace dermap {
namespace {

constexpr int kLocalStartSize = 16;  // pixels along the longer side

// Somewhere in the box of table 1, each place as likely as any other.
SkinPoint RandomPoint(const ParameterSpace& space, SkinPoint point, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (const Parameter p : space.free()) {
    const ParameterInfo& info = InfoOf(p);
    point[static_cast<int>(p)] = std::uniform_real_distribution<double>(info.lower, info.upper)(random);
  }
  return point;
}

}  // namespace

ParameterMaps StartMaps(const PatchProblem& problem, const SkinPoint& fixed, const FitOptions& options,
                        RunLog& log) {
  if (options.resume) return options.resume->maps;
  if (options.start == StartPoint::kLocal) {
    log.Decide("Started from the closed-form inversion of each pixel.");
    const bool averages = options.method == FitMethod::kDescent;
    return averages ? InvertAverages(problem, TableOne(fixed), kLocalStartSize)
                    : InvertLocally(problem, TableOne(fixed));
  }
  if (options.start == StartPoint::kRandom) {
    log.Decide("Started from one random point of table 1 in every pixel, seed " +
               std::to_string(options.seed) + ".");
    return problem.UniformMaps(RandomPoint(problem.space(), fixed, options.seed));
  }
  log.Decide("Started from average skin in every pixel.");
  return problem.UniformMaps(fixed);
}

}  // namespace dermap
