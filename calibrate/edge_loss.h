// SPDX-License-Identifier: Apache-2.0
// Within this folder: the light that skin loses under the tape beside a straight edge, blurred by the lens.
// All lengths in photosites.
#pragma once

namespace dermap {

double NormalIntegral(double z);  // Phi
double NormalDensity(double z);   // phi

// Of the light that skin would show at the distance y inside of an edge, a part exp(-y / length) / 2 is lost:
// half at the edge, by symmetry. Seen through a lens of the standard deviation `blur` that is
//   loss(d) = int_0^inf exp(-y / length) / 2 phi((d - y) / blur) / blur dy
//           = exp(blur^2 / (2 length^2) - d / length) / 2 Phi(d / blur - blur / length).
struct EdgeLoss {
  double loss, by_distance, by_blur;
};
EdgeLoss BlurredLoss(double d, double length, double blur);

}  // namespace dermap
