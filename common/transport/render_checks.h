// SPDX-License-Identifier: Apache-2.0
// What the forward model refuses to render, each as one sentence.
#pragma once

#include <span>

#include "common/transport/forward_model.h"

namespace dermap {

// All throw InputError.
void CheckModelInputs(std::span<const Band> bands, const ImagingConditions& conditions,
                      const ForwardOptions& options);
void CheckMaps(const ParameterMaps& maps, int band_count);
void CheckLight(std::span<const PlaneF> light, const ParameterMaps& maps, int band_count);

}  // namespace dermap
