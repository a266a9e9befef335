// SPDX-License-Identifier: Apache-2.0
// What absorption takes from light at either end of its path, in every pixel.
#pragma once

#include "common/core/image.h"
#include "common/transport/blur.h"

namespace dermap {

// out = exp(-length mu_a), to 2e-7 of its value; length * mu_a >= 0.
void Attenuate(const PlaneF& mu_a, double length_mm, PlaneF& out);

// The Gaussian as wide as half a path strays from its end; empty where it is far narrower than a pixel.
SymmetricKernel StrayKernel(double mean_free_path_mm, double pixel_size_mm);

}  // namespace dermap
