// SPDX-License-Identifier: Apache-2.0
// What the forward model chose for the bands of a scene, as JSON (docs/formats.md, `forward`).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "common/transport/forward_model.h"

namespace dermap {

// One entry a band; empty where the engine does not choose.
nlohmann::ordered_json ChoiceRecord(std::span<const BandChoice> choices, std::span<const Band> bands);

}  // namespace dermap
