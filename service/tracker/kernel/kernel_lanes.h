// Numbers side by side. Included by the kernel files only, each of which is compiled for another instruction set:
// everything here is internal to the including file, nothing may be shared by the linker.
#pragma once

#include "service/base/lanes.h"
#include "service/tracker/kernel/kernel.h"

namespace omni::tracker {
namespace {

template <class Real>
constexpr int kLanes = base::kRegisterLanes<Real>;
template <class Real>
constexpr int kGroups = kBlockSensors / kLanes<Real>;
template <class Real>
using Lane = base::Lanes<Real, kLanes<Real>>;

template <class Real>
struct Lane3 {
  Lane<Real> x, y, z;
};

template <class Real>
inline Lane<Real> Load(const Real* values) {
  Lane<Real> lane;
  base::LoadLanes(values, lane);
  return lane;
}
template <class Real>
inline Lane3<Real> Load3(const Real (*rows)[kBlockSensors], int first) {
  return {Load<Real>(rows[0] + first), Load<Real>(rows[1] + first), Load<Real>(rows[2] + first)};
}
template <class Real>
inline void Store(const Lane<Real>& lane, Real* values) {
  base::StoreLanes(lane, values);
}

inline Lane<float> Sqrt(const Lane<float>& v) {
  Lane<float> roots;
  base::SqrtLanes<float, kLanes<float>>(v, roots);
  return roots;
}
inline Lane<double> Sqrt(const Lane<double>& v) {
  Lane<double> roots;
  base::SqrtLanes<double, kLanes<double>>(v, roots);
  return roots;
}

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
