// SPDX-License-Identifier: Apache-2.0
// The grids that the path engine works on: the patch, ever coarser grids on the way down to the one on which
// light is followed by cosine transforms, and one more, twice as coarse, for light that has gone back and
// forth below the epidermis.
#pragma once

#include <vector>

#include "common/transport/domain.h"
#include "common/transport/forward_model.h"
#include "common/transport/paths/line_map.h"

namespace dermap {

// Tolerances below this are met on finer grids and by longer stencils.
inline constexpr double kStrictTolerance = 1e-4;
inline constexpr double kLooseTolerance = 2e-3;  // from here on shorter stencils do

struct PathFrames {
  // One grid; the patch's corner lies at its pixel (x, y).
  struct Frame {
    int width = 0, height = 0, x = 0, y = 0;
  };

  PathFrames(int patch_width, int patch_height, const ImagingConditions& conditions, double margin_mm,
             const ForwardOptions& options);

  double pixel_size_mm;
  double margin_mm;
  BeneathTape beneath_tape;
  bool window;  // whether light ends at the patch's border; if not, skin and light go on mirrored
  int halvings = 0;
  Domain patch;               // the patch, a little widened so that its sides can be halved
  std::vector<Frame> levels;  // halvings + 1: [0] is the widened patch, the last the transforms' grid
  Frame rest;
  Region skin;  // of the transforms' grid: what arrives beyond it is lost

  const Frame& transforms() const { return levels.back(); }
  double pixel_at(int level) const { return pixel_size_mm * (1 << level); }
  // Light from one grid to the next coarser one; where there are no halvings, from the patch to all skin.
  PlaneMap LightDown(int level) const;
  // What skin does, made coarser, and continued beyond the border as it is there.
  std::vector<PlaneMap> SkinDown() const;
  PlaneMap ToRest() const;
  // Share of each pixel of the rest's grid that lies in the patch; 1 where the skin is, on the transforms'.
  PlaneF PatchShareAtRest() const;
  PlaneF SkinShare() const;
  // What `halvings` steps of LightDown leave of a wave along one axis, `omega` radians per pixel of the
  // patch.
  double GainDown(int to_level, double omega) const;
};

}  // namespace dermap
