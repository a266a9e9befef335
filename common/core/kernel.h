// SPDX-License-Identifier: Apache-2.0
// Runtime dispatch for hot loops: the binary runs on any x86-64 and uses AVX2 or AVX-512 where it is.
// Put DERMAP_KERNEL before a function whose body is a plain loop; the compiler makes one clone an instruction
// set.
#pragma once

// Micro-architecture levels, not processor names: "arch=haswell" is never chosen on another maker's AVX2
// machine, and "avx2" alone leaves fused multiply-add out. A level is chosen by what the processor can do.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(DERMAP_SANITIZED)
#define DERMAP_KERNEL __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define DERMAP_KERNEL
#endif
