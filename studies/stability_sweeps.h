// SPDX-License-Identifier: Apache-2.0
// What is done to a fit, step by step, until it breaks.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "fit/options.h"
#include "studies/stability_bench.h"

namespace dermap {

// One disturbed fit. The method is not yet chosen.
struct StabilityCase {
  ReflectanceStack stack;
  ParameterMaps truth;
  FitOptions options;
  TissueConfig tissue;       // of the truth: options.tissue may be wrong about it
  std::vector<char> judged;  // pixels that count, 0 or 1; empty: all
};

struct Sweep {
  std::string name, label;     // in files; on the chart's axis, with its unit
  std::string judge;           // what the truth's light comes from
  std::vector<double> values;  // on the axis, as they are gone through
  double harmless = 0.0;       // of them: where nothing is disturbed
  bool log = true;             // the axis
  std::vector<FitMethod> methods;
  std::function<StabilityCase(double value, std::uint64_t seed)> make;
  bool small = false;  // few pixels: the reference, too, fits several noises
};

// `bench` must outlive them. Quick: three values a sweep.
std::vector<Sweep> StabilitySweeps(StabilityBench& bench, bool quick);

}  // namespace dermap
