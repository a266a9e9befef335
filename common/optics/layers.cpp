// SPDX-License-Identifier: Apache-2.0
// Adding layers, frequency by frequency.
#include "common/optics/layers.h"

#include <cassert>
#include <cmath>
#include <cstddef>

namespace dermap {

LayerTransforms CombineLayers(const LayerTransforms& top, const LayerTransforms& bottom,
                              double junction_absorbance) {
  const std::size_t count = top.r_forward.size();
  assert(bottom.r_forward.size() == count);
  const double a = std::exp(-junction_absorbance);  // [D08 eq. 8]
  LayerTransforms stack;
  for (std::size_t i = 0; i < count; ++i) {
    const double r1 = top.r_backward[i];
    const double r2 = bottom.r_forward[i];
    // 1 + A^2 R1- R2 + (A^2 R1- R2)^2 + ...: the round trips between the layers. [D08 eq. 3] prints T1- for
    // some R1-.
    const double series = 1.0 / (1.0 - a * a * r1 * r2);
    stack.r_forward.push_back(top.r_forward[i] + top.t_forward[i] * a * r2 * a * top.t_backward[i] * series);
    stack.t_forward.push_back(top.t_forward[i] * a * bottom.t_forward[i] * series);
    stack.r_backward.push_back(bottom.r_backward[i] +
                               bottom.t_backward[i] * a * r1 * a * bottom.t_forward[i] * series);
    stack.t_backward.push_back(bottom.t_backward[i] * a * top.t_backward[i] * series);
  }
  return stack;
}

LayerTransforms CombineLayers(std::span<const LayerTransforms> layers,
                              std::span<const double> junction_absorbance) {
  assert(!layers.empty() && junction_absorbance.size() + 1 == layers.size());
  LayerTransforms stack = layers[0];
  for (std::size_t i = 1; i < layers.size(); ++i) {
    stack = CombineLayers(stack, layers[i], junction_absorbance[i - 1]);
  }
  return stack;
}

LayerTransforms AsLayer(const EpidermisTransforms& epidermis) {
  LayerTransforms layer{epidermis.r_forward, epidermis.t_forward, epidermis.r_backward, epidermis.t_backward};
  for (double& t : layer.t_forward) t += epidermis.t_ballistic;
  return layer;
}

LayerTransforms AsLayer(const DermisTransforms& dermis) {
  const std::vector<double> nothing(dermis.r_diffuse.size(), 0.0);
  return {dermis.r_diffuse, nothing, nothing, nothing};
}

std::vector<double> TwoLayerReflectance(const EpidermisTransforms& epidermis, const DermisTransforms& dermis,
                                        double junction_absorbance) {
  assert(epidermis.r_forward.size() == dermis.r_diffuse.size());
  const double a2 = std::exp(-2.0 * junction_absorbance);
  std::vector<double> reflectance;
  for (std::size_t i = 0; i < epidermis.r_forward.size(); ++i) {
    const double returned =
        epidermis.t_ballistic * dermis.r_normal[i] + epidermis.t_forward[i] * dermis.r_diffuse[i];
    reflectance.push_back(epidermis.r_forward[i] +
                          returned * a2 * epidermis.t_backward[i] /
                              (1.0 - a2 * epidermis.r_backward[i] * dermis.r_diffuse[i]));
  }
  return reflectance;
}

}  // namespace dermap
