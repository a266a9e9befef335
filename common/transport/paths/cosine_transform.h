// SPDX-License-Identifier: Apache-2.0
// The orthonormal cosine transform (DCT-II) of a plane, which diagonalises every convolution with an even
// kernel whose plane goes on mirrored at its border. Small planes, which are nearly all, by matrix products:
// those run at the machine's speed; large ones by OpenCV.
#pragma once

#include <vector>

#include "common/core/image.h"

namespace dermap {

// Keeps its tables and scratch; one a thread.
class CosineTransform {
 public:
  CosineTransform() = default;
  CosineTransform(int width, int height);  // both even
  void Forward(PlaneF& plane);             // in place
  void Inverse(PlaneF& plane);

 private:
  // Along one axis: even and odd halves of a symmetric signal have a basis of half the size each.
  struct Axis {
    int size = 0;
    PlaneF even, odd;                        // [frequency][sample], size / 2 each
    PlaneF even_transposed, odd_transposed;  // [sample][frequency]
  };
  static Axis MakeAxis(int size);
  struct Scratch {
    PlaneF even, odd, even_out, odd_out;
  };
  void Columns(const Axis& axis, bool forward, const PlaneF& in, PlaneF& out);
  void Rows(const Axis& axis, bool forward, const PlaneF& in, PlaneF& out);
  void ByOpenCv(PlaneF& plane, bool forward);

  Axis x_, y_;
  bool large_ = false;
  PlaneF between_;
  Scratch columns_, rows_;
};

}  // namespace dermap
