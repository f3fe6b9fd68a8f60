#include "tests/runtime/spaces/motion.h"

#include <cmath>

namespace omni::runtime {

bool IsValid(const XrPosef& pose) {
  const XrQuaternionf& q = pose.orientation;
  const float norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return norm >= 0.99f && norm <= 1.01f && std::isfinite(pose.position.x) && std::isfinite(pose.position.y) &&
         std::isfinite(pose.position.z);
}

XrPosef Normalized(const XrPosef& pose) {
  const XrQuaternionf& q = pose.orientation;
  const float norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {{q.x / norm, q.y / norm, q.z / norm, q.w / norm}, pose.position};
}

Motion Extrapolate(const Motion& motion, float dt_s) {
  Motion result = motion;
  const XrVector3f& v = motion.linear_m_s;
  const XrVector3f& w = motion.angular_rad_s;
  result.pose.position = Add(motion.pose.position, {v.x * dt_s, v.y * dt_s, v.z * dt_s});
  const float rate = std::sqrt(w.x * w.x + w.y * w.y + w.z * w.z);
  if (rate > 0) {
    const float half = 0.5f * rate * dt_s;
    const float scale = std::sin(half) / rate;
    const XrQuaternionf turn{w.x * scale, w.y * scale, w.z * scale, std::cos(half)};
    result.pose.orientation = Multiply(turn, motion.pose.orientation);
    result.pose = Normalized(result.pose);
  }
  return result;
}

// p = p_A + R_A r,  v = v_A + w_A x (R_A r)
Motion Attach(const Motion& motion, const XrPosef& offset) {
  const XrVector3f arm = Rotate(motion.pose.orientation, offset.position);
  return {Compose(motion.pose, offset), Add(motion.linear_m_s, Cross(motion.angular_rad_s, arm)), motion.angular_rad_s};
}

// v_rel = R_B^T (v - v_B - w_B x (p - p_B)),  w_rel = R_B^T (w - w_B)
Motion Relative(const Motion& base, const Motion& motion) {
  const XrPosef X_BW = Inverse(base.pose);
  const XrVector3f arm = Subtract(motion.pose.position, base.pose.position);
  const XrVector3f carried = Add(base.linear_m_s, Cross(base.angular_rad_s, arm));
  return {Normalized(Compose(X_BW, motion.pose)), Rotate(X_BW.orientation, Subtract(motion.linear_m_s, carried)),
          Rotate(X_BW.orientation, Subtract(motion.angular_rad_s, base.angular_rad_s))};
}

}  // namespace omni::runtime
