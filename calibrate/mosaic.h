// SPDX-License-Identifier: Apache-2.0
// A skin frame beside the Spectralon frame of its filter, photosite by photosite: each photosite divided by
// itself measures reflectance, whatever its colour, since light through a narrow filter has nearly one
// colour. So nothing is demosaiced; the four lattices of the Bayer pattern are four measurements of one
// image, each with its own noise.
//
// Camera coordinates: the photosite (i, j) covers [i, i+1] x [j, j+1]; its centre is at (i + 0.5, j + 0.5),
// where the lens does not distort; where it does, `lens` leads from camera coordinates to photosites.
#pragma once

#include <cmath>

#include "calibrate/frames.h"
#include "calibrate/patch_map.h"

namespace dermap {

struct Mosaic {
  int x0 = 0;  // of this crop within the frame; even
  int y0 = 0;
  PlaneF skin;        // DN above black
  PlaneF spectralon;  // DN above black
  MaskPlane mask;     // 0: usable
  // What was taken off the signals of each kind: light all the same, whose shot noise is still in them.
  OfKinds skin_off{}, spectralon_off{};
  double scale = 1.0;    // reflectance = scale skin / spectralon: certificate and the flash's drift
  double surface = 0.0;  // reflectance by light from skin's surface, none that has spread within
  Lens lens;
  int period = 2;  // of the filter pattern
  int width() const { return skin.width(); }
  int height() const { return skin.height(); }
};

// Part of a mosaic: corners are moved outwards to even photosites and clipped to the frame.
Mosaic Crop(const Mosaic& mosaic, double left, double top, double right, double bottom);

// The four photosites of one lattice around a point (photosites of the frame), and their bilinear weights. A
// lattice is linear in between its own photosites, so a gradient of the image is no error, however unequal
// the lattices' weights.
struct LatticeCell {
  int x, y;  // the upper left photosite, in crop coordinates; the others lie two further
  double fx, fy;
  bool inside;
};
inline LatticeCell CellAt(const Mosaic& mosaic, int lattice, Point photosites) {
  const int ox = lattice & 1;
  const int oy = lattice >> 1;
  const double u = (photosites.x - mosaic.x0 - 0.5 - ox) / 2.0;
  const double v = (photosites.y - mosaic.y0 - 0.5 - oy) / 2.0;
  const auto floor_of = [](double w) {  // std::floor is a call where the processor may lack SSE 4.1
    const int whole = static_cast<int>(w);
    return w < whole ? whole - 1 : whole;
  };
  const int iu = floor_of(u);
  const int iv = floor_of(v);
  LatticeCell cell{2 * iu + ox, 2 * iv + oy, u - iu, v - iv, false};
  cell.inside = cell.x >= 0 && cell.y >= 0 && cell.x + 2 < mosaic.width() && cell.y + 2 < mosaic.height();
  return cell;
}

// Reflectance at a point: ratio of the lattices' sums; NaN outside or where masked. For finding edges.
double ReflectanceAt(const Mosaic& mosaic, double camera_x, double camera_y);

// Reflectance of each 2x2 cell: ratio of the usable photosites' sums; 0 where the Spectralon frame is dark
// (less than `darkest` of the brightest cells).
PlaneF CellReflectance(const Mosaic& mosaic, double darkest);

// Means over the nearest usable photosites of each photosite's own kind (5x5, or 3x3 of a long period): what
// the noise is reckoned from, so that weights and error bars do not follow the noise itself.
struct SmoothSignals {
  PlaneF skin, spectralon;
};
SmoothSignals LatticeSmooth(const Mosaic& mosaic);

}  // namespace dermap
