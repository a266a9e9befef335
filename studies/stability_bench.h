// SPDX-License-Identifier: Apache-2.0
// Stacks whose truth is known, to be disturbed: skins one by one from adding-doubling, a strip and a taped
// window from Monte Carlo, freckled skin from the forward model at its most exact.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/files/stack.h"
#include "common/tissue/tissue.h"
#include "common/transport/forward_model.h"

namespace dermap {

// A stack and what it was made from; maps of the stack's shape.
struct KnownStack {
  ReflectanceStack stack;
  ParameterMaps truth;
};

// Bands of 450 to 650 nm, as many as asked for (1 to 12), evenly spread; monochromatic.
std::vector<Band> SpreadBands(int count);

class StabilityBench {
 public:
  // `size`: pixels along a side of the freckled skin, 7.5 mm.
  StabilityBench(int size, std::uint64_t photons);

  // Freckles on skin of C_m 0.06, twice as much inside, rendered by the forward model at tolerance 1e-5. No
  // noise yet.
  const KnownStack& Freckled(const std::vector<Band>& bands);
  // 8 x 8 pixels of 50 mm, so that none sees another's light: skin like `middle` whose contents vary by up to
  // a fifth, in waves of their own, by adding-doubling under wide light.
  KnownStack Skins(const ParameterVector& middle, const TissueConfig& tissue, std::uint64_t seed) const;
  // One row of pixels of 0.06 mm across an edge of melanin, 0.05 to 0.3, which rises (10 to 90 %) over
  // `width_mm`; by Monte Carlo, with its standard error as sigma. Wide light.
  const KnownStack& Edge(double width_mm);
  // A window of 24 x 24 pixels of 0.15 mm on even skin beneath black tape, by Monte Carlo; its eight mirror
  // images, which are one measurement, are averaged.
  const KnownStack& Window();

  const Chromophores& chromophores() const { return chromophores_; }
  // Of the forward model with default options on the stack.
  ForwardModel ModelFor(const ReflectanceStack& stack, const TissueConfig& tissue);

 private:
  int size_;
  std::uint64_t photons_;
  Chromophores chromophores_;
  std::map<std::vector<double>, KnownStack> freckled_;  // by the bands' wavelengths
  std::map<double, KnownStack> edges_;
  std::unique_ptr<KnownStack> window_;
};

// Gaussian noise of `relative` of the reflectance on every datum, added to what sigma there is.
void AddNoise(ReflectanceStack& stack, double relative, std::uint64_t seed);

}  // namespace dermap
