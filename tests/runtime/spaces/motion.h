#pragma once
// Rigid motions in OpenXR's own types: pose, twist, and how they compose.

#include <openxr/openxr.h>

namespace omni::runtime {

inline constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};

// Pose of a frame in the world with the velocity of its origin and its angular velocity, both in world axes.
struct Motion {
  XrPosef pose = kIdentity;
  XrVector3f linear_m_s{0, 0, 0};
  XrVector3f angular_rad_s{0, 0, 0};
};

// Inline: they are most of what xrLocateSpace does.
inline XrVector3f Add(const XrVector3f& a, const XrVector3f& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

inline XrVector3f Subtract(const XrVector3f& a, const XrVector3f& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

inline XrVector3f Cross(const XrVector3f& a, const XrVector3f& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline XrQuaternionf Multiply(const XrQuaternionf& a, const XrQuaternionf& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

// v' = v + 2 w (u x v) + 2 u x (u x v), with q = (u, w)
inline XrVector3f Rotate(const XrQuaternionf& q, const XrVector3f& v) {
  const XrVector3f u{q.x, q.y, q.z};
  const XrVector3f t = Cross(u, v);
  const XrVector3f s = Cross(u, t);
  return {v.x + 2 * (q.w * t.x + s.x), v.y + 2 * (q.w * t.y + s.y), v.z + 2 * (q.w * t.z + s.z)};
}

inline XrPosef Compose(const XrPosef& X_AB, const XrPosef& X_BC) {
  return {Multiply(X_AB.orientation, X_BC.orientation), Add(X_AB.position, Rotate(X_AB.orientation, X_BC.position))};
}

inline XrPosef Inverse(const XrPosef& X_AB) {
  const XrQuaternionf q{-X_AB.orientation.x, -X_AB.orientation.y, -X_AB.orientation.z, X_AB.orientation.w};
  const XrVector3f p = Rotate(q, X_AB.position);
  return {q, {-p.x, -p.y, -p.z}};
}

// The quaternion is within 1 % of unit length and every number is finite: the tolerance of the specification's
// XR_ERROR_POSE_INVALID.
bool IsValid(const XrPosef& pose);
XrPosef Normalized(const XrPosef& pose);

// `motion` carried on for dt at constant twist.
Motion Extrapolate(const Motion& motion, float dt_s);

// The motion of a frame that is fixed to `motion` at `offset`; its origin gains w x r.
Motion Attach(const Motion& motion, const XrPosef& offset);

// `motion` as seen from the moving frame `base`, in the axes of `base`.
Motion Relative(const Motion& base, const Motion& motion);

}  // namespace omni::runtime
