// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Functions whose loops run with the widest vectors that the processor has, in files that CMakeLists.txt has
// compiled with -O3. Only for functions that no header declares: of others clang 14 makes the first version
// alone, for all processors.

#pragma once

// One version for each level of the instruction set, of which the loader takes one. Not for the name of a
// processor (arch=haswell), which is of one maker: those of others would get the version without wide
// vectors. Levels are chosen rightly since gcc 12 and clang 18: gcc 11 refuses them, and clang 14 takes the
// default on every processor. A sanitizer cannot look into the choice, which is made before it has started.
#if !defined(__x86_64__) || !defined(__linux__) || defined(__SANITIZE_ADDRESS__)
#define DOVETAIL_WIDEST_VECTORS
#elif defined(__clang__) ? __clang_major__ < 18 : __GNUC__ < 12
#define DOVETAIL_WIDEST_VECTORS __attribute__((target_clones("avx512f", "fma", "default")))
#else
#define DOVETAIL_WIDEST_VECTORS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#endif

/// What such a function calls becomes part of it, or it would keep the vectors of all processors.
#define DOVETAIL_PART_OF_CALLER inline __attribute__((always_inline))

namespace dovetail {

/// Four or eight numbers, which fit in a register of most processors: loops over arrays, which the compiler
/// unrolls and puts together again, it leaves apart at times.
template <typename Number>
struct WideRegister;
template <>
struct WideRegister<double>
{
  typedef double Part __attribute__((vector_size(32), aligned(8), may_alias));
};
template <>
struct WideRegister<float>
{
  typedef float Part __attribute__((vector_size(32), aligned(4), may_alias));
};

} // namespace dovetail
