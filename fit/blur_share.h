// SPDX-License-Identifier: Apache-2.0
// How much of a change of absorption's detail is still seen at its own place, octave by octave: skin blurs.
#pragma once

#include <span>
#include <vector>

#include "common/transport/forward_model.h"

namespace dermap {

// Change of the logarithm of reflectance that goes with a detail of absorption, as a share of what the same
// change would do in uniform skin: near 1 for detail that is coarse against the way light goes, near 0 for
// fine.
struct BlurShare {
  float epidermis = 1.0f, dermis = 1.0f, junction = 1.0f;
};

// The shares of one octave and band, which grow with absorption (less light goes far): as many as skins were
// tried, by their absorption of the epidermis, ascending.
class BlurCurve {
 public:
  void Add(double mu_a_epidermis, const BlurShare& share);
  // Linear in the logarithm of absorption, constant beyond the ends; all 1 where nothing was added.
  BlurShare At(double mu_a_epidermis) const;

 private:
  std::vector<float> log_mu_a_;
  std::vector<BlurShare> shares_;
};

// [octave][band]; octave 0 is detail of one pixel of the model's size (what Halve and Double lose), each next
// one twice as coarse. Measured on products of the Jacobian with random detail, in skins of the kinds that
// the patch holds: from its lightest to its darkest. The fields are seeded: the same for the same model and
// skins.
using BlurTable = std::vector<std::vector<BlurCurve>>;
BlurTable MeasureBlur(const ForwardModel& model, std::span<const ParameterVector> skins, int octaves);

}  // namespace dermap
