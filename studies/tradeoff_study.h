// SPDX-License-Identifier: Apache-2.0
// Speed against accuracy: one way to render or to fit, on one scene.
#pragma once

#include <cstdint>
#include <string>

#include "common/tissue/parameters.h"

namespace dermap {

struct TradeoffOptions {
  bool quick = false;      // two scenes, small patches, few settings: for tests
  std::uint64_t seed = 1;  // of the noise
};

// One setting on one scene.
struct TradeoffPoint {
  std::string kind;  // render, fit
  std::string scene, setting, family;
  std::string options{};                                  // in words
  int size = 0;                                           // pixels along a side
  double seconds = 0.0, ratio = 0.0, ratio_spread = 0.0;  // ratio: to the default, in pairs
  int pairs = 0;
  bool is_default = false, is_paper = false, extrapolated = false;
  // Render: rms relative to the slow reference, over cells of 0.23 mm. Fit: median errors over what noise
  // alone would leave (NoiseBound), mean of the five parameters, to the truth.
  double error = 0.0, error_bar = 0.0;
  double error_monte_carlo = 0.0, monte_carlo_bar = 0.0;  // 0: the scene has none
  // Fit: median |error| of the parameters, to the truth and to the reference fit, and the bound.
  ParameterVector to_truth{}, to_reference{}, bound{};
  double chi2 = 0.0;
  int renders = 0;
};

}  // namespace dermap
