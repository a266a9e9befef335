// SPDX-License-Identifier: Apache-2.0
// Within this folder: the light that skin loses under the tape beside a straight edge, blurred by the lens,
// as a table over the distance from the edge (photosites).
#pragma once

#include <vector>

namespace dermap {

double NormalIntegral(double z);  // Phi
double NormalDensity(double z);   // phi

// D(d) = int_0^inf (1 - Phi(y / spread)) phi((d - y) / blur) / blur dy: what a profile of the standard
// deviation `spread` takes away at the distance d inside of the edge, seen through a lens of the standard
// deviation `blur`. Half at the edge itself, nothing far inside.
double BlurredLoss(double d, double spread, double blur);

class SpreadTable {
 public:
  SpreadTable(double spread_px, double blur_px, double reach_px);
  struct Values {
    double loss, by_distance, by_blur;
  };
  Values At(double d) const;  // 0 beyond the table

 private:
  double first_, step_;
  std::vector<double> loss_, by_blur_;
};

}  // namespace dermap
