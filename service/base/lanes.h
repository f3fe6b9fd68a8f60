// Numbers side by side, for kernels that are compiled once per instruction set. The including file defines
// OMNI_LANE_BYTES, the width of a register of the set that it is compiled for. Everything here is internal to that
// file, so that the linker has nothing to share with files that run on older processors. Lanes add, multiply and divide
// as numbers do [GCC, "Vector Extensions"]; nothing is fused (-ffp-contract=off), so that all widths give the same
// bits.
#pragma once

#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#ifndef OMNI_LANE_BYTES
#error "lanes.h is for files that are compiled for one instruction set: define OMNI_LANE_BYTES"
#endif

namespace omni::base {
namespace {

template <class Real, int kCount>
struct LanesType {
  typedef Real Type __attribute__((vector_size(kCount * sizeof(Real))));
};
template <class Real, int kCount>
using Lanes = typename LanesType<Real, kCount>::Type;

// How many fit into a register.
template <class Real>
constexpr int kRegisterLanes = OMNI_LANE_BYTES / static_cast<int>(sizeof(Real));

template <class Vector, class Real>
inline void LoadLanes(const Real* values, Vector& lanes) noexcept {
  std::memcpy(&lanes, values, sizeof lanes);
}
template <class Vector, class Real>
inline void StoreLanes(const Vector& lanes, Real* values) noexcept {
  std::memcpy(values, &lanes, sizeof lanes);
}

// Square root of each lane. Wider than a register: in halves. By reference, since a vector that no register holds has
// another calling convention.
template <class Real, int kCount>
inline void SqrtLanes(const Lanes<Real, kCount>& lanes, Lanes<Real, kCount>& roots) noexcept {
  if constexpr (kCount * static_cast<int>(sizeof(Real)) > OMNI_LANE_BYTES) {
    Lanes<Real, kCount / 2> half;
    for (int i = 0; i < 2; ++i) {
      std::memcpy(&half, reinterpret_cast<const char*>(&lanes) + i * sizeof half, sizeof half);
      SqrtLanes<Real, kCount / 2>(half, half);
      std::memcpy(reinterpret_cast<char*>(&roots) + i * sizeof half, &half, sizeof half);
    }
  } else {
#if defined(__x86_64__)
    if constexpr (sizeof(Real) == sizeof(float)) {
#if defined(__AVX__)
      if constexpr (kCount == 8) roots = _mm256_sqrt_ps(lanes);
#endif
      if constexpr (kCount == 4) roots = _mm_sqrt_ps(lanes);
    } else {
#if defined(__AVX__)
      if constexpr (kCount == 4) roots = _mm256_sqrt_pd(lanes);
#endif
      if constexpr (kCount == 2) roots = _mm_sqrt_pd(lanes);
    }
#else
    for (int i = 0; i < kCount; ++i) roots[i] = std::sqrt(lanes[i]);
#endif
  }
}

}  // namespace
}  // namespace omni::base
