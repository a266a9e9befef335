// SPDX-License-Identifier: Apache-2.0
// Sixteen floats side by side, for the few loops whose speed depends on what stays in registers. The compiler
// makes of them what the processor has (kernel.h).
#pragma once

namespace dermap {

typedef float Lanes __attribute__((vector_size(64)));
inline constexpr int kLanes = 16;

// From and to anywhere in memory.
typedef float LanesInMemory __attribute__((vector_size(64), aligned(4), may_alias));
#define DERMAP_LOAD(p) (*reinterpret_cast<const ::dermap::LanesInMemory*>(p))
#define DERMAP_STORE(p, lanes) (*reinterpret_cast<::dermap::LanesInMemory*>(p) = (lanes))

}  // namespace dermap
