// Numbers side by side. Included by the kernel files only, each of which is compiled for another instruction set:
// everything here is internal to the including file, nothing may be shared by the linker.
#pragma once

#include <immintrin.h>

#include <cstring>

#include "service/tracker/kernel/kernel.h"

#ifndef OMNI_KERNEL_BYTES
#error "kernel_lanes.h is for the kernel files: define OMNI_KERNEL_BYTES, the vector width"
#endif

namespace omni::tracker {
namespace {

template <class Real>
constexpr int kLanes = OMNI_KERNEL_BYTES / static_cast<int>(sizeof(Real)) < kBlockSensors
                           ? OMNI_KERNEL_BYTES / static_cast<int>(sizeof(Real))
                           : kBlockSensors;
template <class Real>
constexpr int kGroups = kBlockSensors / kLanes<Real>;

template <class Real>
struct LaneType {
  typedef Real Type __attribute__((vector_size(kLanes<Real> * sizeof(Real))));
};
template <class Real>
using Lane = typename LaneType<Real>::Type;

template <class Real>
struct Lane3 {
  Lane<Real> x, y, z;
};

template <class Real>
inline Lane<Real> Load(const Real* values) {
  Lane<Real> lane;
  std::memcpy(&lane, values, sizeof lane);
  return lane;
}
template <class Real>
inline Lane3<Real> Load3(const Real (*rows)[kBlockSensors], int first) {
  return {Load<Real>(rows[0] + first), Load<Real>(rows[1] + first), Load<Real>(rows[2] + first)};
}
template <class Real>
inline void Store(const Lane<Real>& lane, Real* values) {
  std::memcpy(values, &lane, sizeof lane);
}

#if OMNI_KERNEL_BYTES == 16
inline Lane<float> Sqrt(Lane<float> v) { return _mm_sqrt_ps(v); }
inline Lane<double> Sqrt(Lane<double> v) { return _mm_sqrt_pd(v); }
#else
inline Lane<float> Sqrt(Lane<float> v) { return _mm256_sqrt_ps(v); }
#if OMNI_KERNEL_BYTES == 32
inline Lane<double> Sqrt(Lane<double> v) { return _mm256_sqrt_pd(v); }
#else
// Masked: the plain one reads an undefined register, of which GCC 12 warns.
inline Lane<double> Sqrt(Lane<double> v) { return _mm512_maskz_sqrt_pd(0xff, v); }
#endif
#endif

template <class Real>
inline Lane<Real> Dot(const Lane3<Real>& a, const Lane3<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
inline Lane<Real> Dot(const Real (&a)[3], const Lane3<Real>& b) {
  return a[0] * b.x + a[1] * b.y + a[2] * b.z;
}

// The sum over a block's eight lanes, the same bits for every width: lanes i and i + 4, then i + 2, then i + 1.
// `groups`: kGroups lanes, `stride` apart.
template <class Real>
inline double SumBlock(const Lane<Real>* groups, int stride) {
  if constexpr (kGroups<Real> == 4) {
    const Lane<Real> v = (groups[0] + groups[2 * stride]) + (groups[stride] + groups[3 * stride]);
    return static_cast<double>(v[0] + v[1]);
  } else if constexpr (kGroups<Real> == 2) {
    const Lane<Real> v = groups[0] + groups[stride];
    return static_cast<double>((v[0] + v[2]) + (v[1] + v[3]));
  } else {
    const Lane<Real>& w = groups[0];
    const auto v = __builtin_shufflevector(w, w, 0, 1, 2, 3) + __builtin_shufflevector(w, w, 4, 5, 6, 7);
    return static_cast<double>((v[0] + v[2]) + (v[1] + v[3]));
  }
}

}  // namespace
}  // namespace omni::tracker
