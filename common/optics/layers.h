// SPDX-License-Identifier: Apache-2.0
// Homogeneous layers combined into stacks: adding, at each lateral frequency on its own (convolutions become
// products) [D08 3, eq. 3 as a geometric series], with an infinitely thin absorber between layers [D08 eq.
// 8].
#pragma once

#include <span>
#include <vector>

#include "common/optics/profile_source.h"

namespace dermap {

// A layer, or a stack of them, at some frequencies. Forward is downwards.
struct LayerTransforms {
  std::vector<double> r_forward, t_forward, r_backward, t_backward;
};

// `top` over `bottom`, with absorbance P between: A = exp(-P) acts on light that crosses, not on what a face
// reflects.
LayerTransforms CombineLayers(const LayerTransforms& top, const LayerTransforms& bottom,
                              double junction_absorbance);

// Any number of layers, from the top; junction_absorbance[i] lies below layers[i] (one fewer than layers).
LayerTransforms CombineLayers(std::span<const LayerTransforms> layers,
                              std::span<const double> junction_absorbance);

// A layer as it stands in a stack, ballistic light counted with the diffuse; and a half-space, which
// transmits nothing.
LayerTransforms AsLayer(const EpidermisTransforms& epidermis);
LayerTransforms AsLayer(const DermisTransforms& dermis);

// Two-layer reflectance from above, the ballistic part kept apart, one formula for sources with and without
// it: R1+ + (Tb R2n + T1+ R2d) A^2 T1- / (1 - A^2 R1- R2d).
std::vector<double> TwoLayerReflectance(const EpidermisTransforms& epidermis, const DermisTransforms& dermis,
                                        double junction_absorbance);

}  // namespace dermap
