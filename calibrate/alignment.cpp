// SPDX-License-Identifier: Apache-2.0
// Each band against the mean of all others, from coarse to fine.
#include "calibrate/alignment.h"

#include <algorithm>
#include <cmath>

#include "calibrate/alignment_search.h"
#include "calibrate/alignment_structure.h"
#include "calibrate/statistics.h"
#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr int kPasses = 4;                // the mean of the others becomes sharper as they move into place
constexpr double kCoarseSmooth_px = 3.0;  // of the first search, which catches shifts of several pixels
// What is expected of the modes, one standard deviation, pixels: shift, strain and rotation, bulges. The
// window has been followed already; on skin without much structure more freedom would only follow noise.
constexpr WarpPrior kPrior_px{0.5, 0.15, 0.15, 0.3, 0.15, 0.15};
constexpr int kAffineModes = 3;
constexpr double kSkinAtTape_px = 0.03;  // what the tape lets skin move at its border, one standard deviation

WarpPrior PriorOf(double window_sigma_px) {
  WarpPrior prior = kPrior_px;
  for (int i = 0; i < kAffineModes; ++i)
    prior[i] = std::min(prior[i], std::hypot(window_sigma_px, kSkinAtTape_px));
  return prior;
}

// All bands move at once, each towards the mean of the others, so each goes only its share of the way: else
// they would pass one another (two bands would swap places for ever).
void Damp(const Warp& before, double share, Warp& warp) {
  for (std::size_t i = 0; i < warp.p.size(); ++i) warp.p[i] = before.p[i] + share * (warp.p[i] - before.p[i]);
}

// What the warp is in words.
void Describe(int width_px, BandAlignment& a) {
  const auto& p = a.warp.p;
  const Point middle = a.warp.At({0.5, 0.5});
  a.dx_px = middle.x;
  a.dy_px = middle.y;
  const double turn = 0.5 * (p[Warp::kModes + 1] - p[2]);  // pixels at the border
  a.angle_rad = turn / (0.5 * width_px);
  a.stretch_px = 0.0;
  for (int y = 0; y <= 8; ++y) {
    for (int x = 0; x <= 8; ++x) {
      const Point unit{x / 8.0, y / 8.0};
      const Point d = a.warp.At(unit);
      const double sx = d.x - p[0] + turn * (2 * unit.y - 1);
      const double sy = d.y - p[Warp::kModes] - turn * (2 * unit.x - 1);
      a.stretch_px = std::max(a.stretch_px, std::hypot(sx, sy));
    }
  }
}

void Judge(const AlignmentOptions& options, int width_px, BandAlignment& a) {
  Describe(width_px, a);
  const double shift = a.found_shift_px = std::hypot(a.dx_px, a.dy_px);
  if (!(a.correlation >= options.smallest_correlation) ||
      !(a.uncertainty_px <= options.largest_uncertainty_px)) {
    a.note = "shares too little structure with the other bands (correlation " + Short(a.correlation) +
             ", shift known to " + Short(a.uncertainty_px) + " px): the window's own alignment is kept";
  } else if (shift > options.largest_shift_px) {
    a.clearly_off = true;
    a.note = "lies " + Short(shift) + " px off the other bands inside the window";
  } else {
    a.applied = true;
  }
  if (!a.applied) {
    a.warp = {};
    Describe(width_px, a);
  }
}

// The bands' windows are, on average, where the patch is: alignment must not move the whole stack.
void RemoveMean(int width_px, std::vector<BandAlignment>& bands) {
  Warp mean;
  const auto count = std::count_if(bands.begin(), bands.end(), [](const auto& a) { return a.applied; });
  for (const auto& a : bands) {
    for (std::size_t i = 0; a.applied && i < mean.p.size(); ++i) mean.p[i] += a.warp.p[i] / double(count);
  }
  for (auto& a : bands) {
    if (!a.applied) continue;
    for (std::size_t i = 0; i < mean.p.size(); ++i) a.warp.p[i] -= mean.p[i];
    Describe(width_px, a);
  }
}

// One band against the mean of the others, from where all of them are now.
BandAlignment AlignBand(const Structure& own, const PlaneF& reference, const BandAlignment& before,
                        const WarpPrior& prior, bool first, double share, const AlignmentOptions& options) {
  BandAlignment found;
  if (own.weight <= 0.0 || reference.empty()) {
    found.note = "shows no structure above its noise: the window's own alignment is kept";
    return found;
  }
  found.warp = before.warp;
  if (first) {
    const SlopedPicture coarse_reference(Smoothed(reference, kCoarseSmooth_px));
    const double smooth_px = std::hypot(kStructureSmooth_px, kCoarseSmooth_px);
    SearchWarp({coarse_reference, Smoothed(own.picture, kCoarseSmooth_px), own.mask, smooth_px, 1, kPrior_px},
               found.warp);
  }
  const SlopedPicture sloped(reference);
  WarpProblem problem{sloped, own.picture, own.mask, kStructureSmooth_px, kAffineModes, prior};
  SearchWarp(problem, found.warp);
  problem.modes = Warp::kModes;
  const WarpFit fit = SearchWarp(problem, found.warp);
  found.correlation = fit.correlation;
  found.uncertainty_px = fit.uncertainty_px;
  Damp(before.warp, share, found.warp);
  Judge(options, own.mask.width(), found);
  return found;
}

PlaneF Residual(const Structure& own, const PlaneF& moved, const PlaneF& reference, double correlation) {
  PlaneF residual(moved.width(), moved.height(), std::nanf(""));
  if (reference.empty()) return residual;
  for (int y = 0; y < moved.height(); ++y) {
    for (int x = 0; x < moved.width(); ++x) {
      if (own.mask(x, y) != 0)
        residual(x, y) = static_cast<float>(correlation) * moved(x, y) - reference(x, y);
    }
  }
  return residual;
}

}  // namespace

std::vector<BandAlignment> AlignBands(std::span<const PlaneF> reflectance, std::span<const PlaneF> noise,
                                      std::span<const double> window_sigma_px,
                                      const AlignmentOptions& options) {
  const auto count = static_cast<int>(reflectance.size());
  std::vector<Structure> structures(reflectance.size());
  ParallelFor(count,
              [&](int i) { structures[i] = StructureOf(reflectance[i], noise[i], options.border_px); });
  const auto sharing =
      std::count_if(structures.begin(), structures.end(), [](const auto& s) { return s.weight > 0.0; });
  const double share = sharing > 0 ? (double(sharing) - 1.0) / double(sharing) : 0.0;
  const int width = reflectance.empty() ? 0 : reflectance[0].width();
  std::vector<BandAlignment> bands(reflectance.size());
  std::vector<PlaneF> moved(reflectance.size());
  const auto move_all = [&] {
    ParallelFor(count, [&](int i) { moved[i] = Moved(structures[i].picture, bands[i].warp); });
  };
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<BandAlignment> next = bands;
    move_all();
    ParallelFor(count, [&](int i) {
      if (pass > 0 && !bands[i].applied) return;
      const PlaneF reference = MeanOfOthers(structures, moved, static_cast<std::size_t>(i));
      const WarpPrior prior = window_sigma_px.empty() ? kPrior_px : PriorOf(window_sigma_px[i]);
      next[i] = AlignBand(structures[i], reference, bands[i], prior, pass == 0, share, options);
    });
    RemoveMean(width, next);
    double settled = 0.0;
    for (int i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < next[i].warp.p.size(); ++k)
        settled = std::max(settled, std::abs(next[i].warp.p[k] - bands[i].warp.p[k]));
    }
    bands = std::move(next);
    if (settled < kSettledWarp_px) break;
  }
  move_all();
  ParallelFor(count, [&](int i) {
    const PlaneF reference = MeanOfOthers(structures, moved, static_cast<std::size_t>(i));
    bands[i].residual = Residual(structures[i], moved[i], reference, bands[i].correlation);
  });
  return bands;
}

}  // namespace dermap
