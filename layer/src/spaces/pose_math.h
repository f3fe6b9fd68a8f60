// Poses and motions with GLM (double inside, XrPosef at the edge).
// Monogram notation: X_AB is the pose of frame B in frame A; p_AB, q_AB its parts; v_AB, w_AB the velocity of B's
// origin and B's angular velocity, both relative to A and expressed in A.
#pragma once

#include <array>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

struct Pose {
  glm::dvec3 p{0.0};
  glm::dquat q{1.0, 0.0, 0.0, 0.0};  // w, x, y, z
};

struct Motion {
  Pose X;
  glm::dvec3 v{0.0};
  glm::dvec3 w{0.0};
};

Pose Compose(const Pose& X_AB, const Pose& X_BC) noexcept;
Pose Inverse(const Pose& X_AB) noexcept;

// X_AC with its velocity, lever arm included.
Motion Compose(const Motion& X_AB, const Motion& X_BC) noexcept;
Motion Inverse(const Motion& X_AB) noexcept;

Pose FromXr(const XrPosef& pose) noexcept;
XrPosef ToXr(const Pose& pose) noexcept;  // unit quaternion in single precision
glm::dvec3 FromXr(const XrVector3f& v) noexcept;
XrVector3f ToXr(const glm::dvec3& v) noexcept;
std::array<double, 3> ToArray(const glm::dvec3& v) noexcept;  // as in the service's messages

// All components are finite.
bool IsFinite(const XrVector3f& v) noexcept;
bool IsFinite(const Motion& m) noexcept;

// After dt_s at its present velocities.
Motion MovedOn(const Motion& motion, double dt_s) noexcept;

// Rotation by the vector w (axis times angle, rad).
glm::dquat ExpRotation(const glm::dvec3& w) noexcept;

}  // namespace omni::layer
