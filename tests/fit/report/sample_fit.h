// SPDX-License-Identifier: Apache-2.0
// A made-up fit result for tests of the report: freckles and a vein, noise with a fixed seed. It is not
// physics: the report must only show what it is given.
#pragma once

#include "common/files/maps.h"
#include "fit/fit_result.h"

namespace dermap {

struct SampleFit {
  FitResult fit;
  MapsFile truth;  // at twice the fit's size
};

SampleFit MakeSampleFit(int width, int height, int bands = 8);

}  // namespace dermap
