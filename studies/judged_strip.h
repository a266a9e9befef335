// SPDX-License-Identifier: Apache-2.0
// A strip of skin that changes along x only: what a Monte Carlo says that it reflects, and what the forward
// model says. Nothing changes along y, so every photon counts for the one row that there is.
#pragma once

#include <cstdint>
#include <vector>

#include "common/transport/forward_model.h"

namespace dermap {

// Under wide light; beyond either end the strip goes on as its own mirror image.
struct Strip {
  double wavelength_nm = 560.0;
  double pixel_size_mm = 0.03;
  std::vector<ParameterVector> skin;  // one a pixel
};

// Average skin whose melanin rises from C_m 0.05 to 0.3 along the strip, the middle 80 % of the rise over
// `width_mm`, with `beside_mm` of even skin on either side.
std::vector<ParameterVector> MelaninEdge(double width_mm, double pixel_mm, double beside_mm);

struct JudgedStrip {
  std::vector<double> reflectance, standard_error;  // one a pixel
};
JudgedStrip JudgeStrip(const Strip& strip, const Chromophores& chromophores, std::uint64_t photons,
                       std::uint64_t seed, int threads);

std::vector<double> RenderStrip(const Strip& strip, const Chromophores& chromophores,
                                const ProfileSource& source, Coupling coupling);

// Relative to the judge, over the pixels.
struct StripMisfit {
  double rms = 0.0;    // of rendered / judged - 1
  double noise = 0.0;  // likewise, of the judge's standard error
  double net = 0.0;    // what is left of rms without the noise
  double worst = 0.0;  // largest deviation that three standard errors do not explain
};
StripMisfit Compare(const std::vector<double>& rendered, const JudgedStrip& judge);

}  // namespace dermap
