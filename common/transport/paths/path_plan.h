// SPDX-License-Identifier: Apache-2.0
// All that the path engine must know of a wavelength before it sees a scene's pixels: path lengths over the
// scene's range of absorption, and the kernels of every response along them, on the grids where they act.
//
// The response of a layer between entry x' and exit x is, over path lengths L_j,
//   P(x, x') = sum_j a_j(x) p_j(x - x') a_j(x'),   a_j = S * exp(-mu_a L_j / 2):
// half of a path lies near either end, so it is absorbed as if all skin had the mean of both ends'
// absorption; S is a Gaussian as wide as such a half strays (kSpread), so an end is the mean of its
// neighbourhood's transmittances: light that survives is light that strayed to where it is bright. [D08 4.1]
// takes the absorption at the exit alone for the whole path, which is not reciprocal and, against Monte
// Carlo, far from it at a sharp edge (docs/heterogeneous_skin.md); it is kept as Coupling::kGather, P(x, x')
// = sum_j exp(-mu_a(x) L_j) p_j(x - x').
//
// What leaves the surface without having seen the dermis has structure as fine as the pixels. Its kernel is
// split, p = p (1 - G_1) + p (G_1 - G_2) + ... + p G_n with ever wider Gaussians G_i, and each part acts on
// the grid that is just fine enough: the last by cosine transforms, the others, which are short, as stencils.
// All else goes through both layers and is smooth: it lives on the transforms' grid.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "common/optics/path_kernels.h"
#include "common/transport/forward_model.h"
#include "common/transport/paths/path_frames.h"
#include "common/transport/paths/stencil.h"

namespace dermap {

// The range of mu_a in a map, wider by some, on a grid of its logarithm: maps that differ little are seen
// through the same path lengths, so that a render is a smooth function of its maps.
struct AbsorptionRange {
  double lowest, highest;  // 1/mm, within the tables
  bool operator==(const AbsorptionRange&) const = default;
};
// Of a map whose values differ by no more than `tolerance`, relative: just as wide as it is.
AbsorptionRange RangeOf(const PlaneF& mu_a, double tolerance = 0.0);

struct PathPlan {
  // One layer's responses: planes of transforms, [path].
  struct Kernels {
    std::vector<PlaneF> planes;
    std::vector<double> totals;  // at frequency 0
  };

  std::vector<double> epidermis_mm, dermis_mm;  // path lengths
  double error = 0.0;                           // of the path sums, relative to a response's total
  Kernels r1_forward, t1_forward, t1_backward, r2_diffuse, r2_normal;  // on the transforms' grid
  Kernels r1_backward_rest, r1_backward_black_rest, r2_diffuse_rest;   // on the rest's grid
  // [level][path]: what r1_forward does on the finer grids; by the shortest paths, as many as it needs there.
  std::vector<std::vector<Stencil>> surface;
  // Share of light that crosses the epidermis unscattered: ballistic_share exp(-mu_a ballistic_mm).
  double ballistic_share = 0.0, ballistic_mm = 0.0;
};

// Plans of a model's bands, made when they are first asked for; any thread may ask.
class PathPlans {
 public:
  std::shared_ptr<const PathPlan> Get(const BandTables& tables, const AbsorptionRange& epidermis,
                                      const AbsorptionRange& dermis, bool black_tape,
                                      const PathFrames& frames, const ForwardOptions& options);

 private:
  struct Entry;
  std::mutex mutex_;
  std::vector<std::shared_ptr<Entry>> entries_;  // guarded by mutex_; the last used last
};

}  // namespace dermap
