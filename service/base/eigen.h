// Conversions between the seam vectors and Eigen. Values only: no views, no aliasing.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "service/base/vec.h"

namespace omni::base {

inline Eigen::Vector3d ToEigen(const Vec3& v) { return {v.x, v.y, v.z}; }
inline Vec3 FromEigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
inline Eigen::Quaterniond ToEigen(const Quat& q) { return {q.w, q.x, q.y, q.z}; }
inline Quat FromEigen(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

}  // namespace omni::base
