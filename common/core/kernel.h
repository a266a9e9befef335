// SPDX-License-Identifier: Apache-2.0
// Runtime dispatch for hot loops: the binary runs on any x86-64 and uses AVX2 or AVX-512 where it is.
// Put DERMAP_KERNEL before a function whose body is a plain loop; the compiler makes one clone an instruction set.
#pragma once

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(DERMAP_SANITIZED)
#define DERMAP_KERNEL __attribute__((target_clones("arch=skylake-avx512", "arch=haswell", "default")))
#else
#define DERMAP_KERNEL
#endif
