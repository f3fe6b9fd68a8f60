#include "layer/src/spaces/pose_math.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace omni::layer {

Pose Compose(const Pose& X_AB, const Pose& X_BC) noexcept {
  return {X_AB.p + X_AB.q * X_BC.p, glm::normalize(X_AB.q * X_BC.q)};
}

Pose Inverse(const Pose& X_AB) noexcept {
  const glm::dquat q_BA = glm::conjugate(X_AB.q);
  return {-(q_BA * X_AB.p), q_BA};
}

// v_AC = v_AB + w_AB x (R_AB p_BC) + R_AB v_BC,   w_AC = w_AB + R_AB w_BC
Motion Compose(const Motion& X_AB, const Motion& X_BC) noexcept {
  Motion out;
  out.X = Compose(X_AB.X, X_BC.X);
  const glm::dvec3 lever_A = X_AB.X.q * X_BC.X.p;
  out.v = X_AB.v + glm::cross(X_AB.w, lever_A) + X_AB.X.q * X_BC.v;
  out.w = X_AB.w + X_AB.X.q * X_BC.w;
  return out;
}

// p_BA = -R' p with dR'/dt = -R' [w]x, hence v_BA = R' (w x p - v), w_BA = -R' w
Motion Inverse(const Motion& X_AB) noexcept {
  Motion out;
  out.X = Inverse(X_AB.X);
  out.v = out.X.q * (glm::cross(X_AB.w, X_AB.X.p) - X_AB.v);
  out.w = -(out.X.q * X_AB.w);
  return out;
}

glm::dvec3 FromXr(const XrVector3f& v) noexcept { return {v.x, v.y, v.z}; }

XrVector3f ToXr(const glm::dvec3& v) noexcept {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

std::array<double, 3> ToArray(const glm::dvec3& v) noexcept { return {v.x, v.y, v.z}; }

bool IsFinite(const XrVector3f& v) noexcept { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

bool IsFinite(const Motion& m) noexcept {
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += m.X.p[i] + m.v[i] + m.w[i];
  return std::isfinite(sum + m.X.q.w + m.X.q.x + m.X.q.y + m.X.q.z);
}

Pose FromXr(const XrPosef& pose) noexcept {
  const XrQuaternionf& o = pose.orientation;
  const glm::dquat q(o.w, o.x, o.y, o.z);
  // The runtime has validated the quaternion to 1 %; a zero one must not become NaN.
  return {FromXr(pose.position), glm::length(q) > 0.5 ? glm::normalize(q) : glm::dquat(1.0, 0.0, 0.0, 0.0)};
}

XrPosef ToXr(const Pose& pose) noexcept {
  const glm::dquat q = glm::normalize(pose.q);
  return {{static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)},
          ToXr(pose.p)};
}

Motion MovedOn(const Motion& motion, double dt_s) noexcept {
  Motion m = motion;
  m.X.p += dt_s * m.v;
  m.X.q = glm::normalize(ExpRotation(dt_s * m.w) * m.X.q);
  return m;
}

glm::dquat ExpRotation(const glm::dvec3& w) noexcept {
  const double angle = glm::length(w);
  // sin(a/2)/a -> 1/2 for a -> 0
  const double s = angle > 1e-9 ? std::sin(0.5 * angle) / angle : 0.5;
  return glm::normalize(glm::dquat(std::cos(0.5 * angle), s * w.x, s * w.y, s * w.z));
}

}  // namespace omni::layer
