#include "layer/src/tool_motion.h"

#include <algorithm>

#include "layer/src/fault.h"

namespace omni::layer {
namespace {

glm::dvec3 Vec(const std::array<double, 3>& a) noexcept { return {a[0], a[1], a[2]}; }

Motion MotionOf(const protocol::ToolSample& s) noexcept {
  Motion m;
  m.X.p = Vec(s.position_base_m);
  const auto& q = s.orientation_base_wxyz;
  m.X.q = glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]));
  m.v = Vec(s.linear_velocity_base_m_s);
  m.w = Vec(s.angular_velocity_base_rad_s);
  return m;
}

bool Has(const protocol::ToolSample& s, std::uint32_t flag) noexcept { return (s.flags & flag) != 0; }

}  // namespace

Motion Interpolate(const protocol::ToolSample& before, const protocol::ToolSample& after, std::int64_t t_ns) noexcept {
  if (after.t_ns <= before.t_ns) return MotionOf(after);
  const Motion m0 = MotionOf(before);
  const Motion m1 = MotionOf(after);
  const double h = 1e-9 * static_cast<double>(after.t_ns - before.t_ns);
  const double s = 1e-9 * static_cast<double>(t_ns - before.t_ns) / h;
  // Hermite basis: p(s) = h00 p0 + h10 h v0 + h01 p1 + h11 h v1, v = dp/ds / h
  const double s2 = s * s;
  const double s3 = s2 * s;
  Motion m;
  m.X.p =
      (2 * s3 - 3 * s2 + 1) * m0.X.p + (s3 - 2 * s2 + s) * h * m0.v + (3 * s2 - 2 * s3) * m1.X.p + (s3 - s2) * h * m1.v;
  m.v = ((6 * s2 - 6 * s) / h) * (m0.X.p - m1.X.p) + (3 * s2 - 4 * s + 1) * m0.v + (3 * s2 - 2 * s) * m1.v;
  m.X.q = glm::slerp(m0.X.q, m1.X.q, s);
  m.w = (1 - s) * m0.w + s * m1.w;
  return m;
}

Motion Predict(const protocol::ToolSample& sample, std::int64_t t_ns) noexcept {
  Motion m = MotionOf(sample);
  const std::int64_t longest_ns = OMNI_FAULT("prediction-without-end") ? 1'000'000'000 : kMaxPrediction_ns;
  const double dt = 1e-9 * static_cast<double>(std::clamp<std::int64_t>(t_ns - sample.t_ns, 0, longest_ns));
  m.X.p += dt * m.v;
  m.X.q = glm::normalize(ExpRotation(dt * m.w) * m.X.q);
  return m;
}

ToolMotion ToolMotionAt(const client::StateReader& reader, std::int64_t t_ns, std::int64_t now_ns) noexcept {
  ToolMotion out;
  protocol::ToolSample newest;
  if (!reader.Newest(newest)) return out;
  if (now_ns - newest.t_ns > kPresenceTimeout_ns && !OMNI_FAULT("stale-pen-valid")) return out;
  if (t_ns >= newest.t_ns) {
    out.valid = Has(newest, protocol::kToolPoseValid);
    out.tracked = out.valid && Has(newest, protocol::kToolTracked);
    if (out.valid) out.X_BT = Predict(newest, t_ns);
    return out;
  }
  protocol::ToolSample before;
  protocol::ToolSample after;
  if (!reader.Around(t_ns, before, after)) return out;
  const bool before_valid = Has(before, protocol::kToolPoseValid);
  const bool after_valid = Has(after, protocol::kToolPoseValid);
  out.valid = before_valid || after_valid;
  out.tracked =
      before_valid && after_valid && Has(before, protocol::kToolTracked) && Has(after, protocol::kToolTracked);
  if (before_valid && after_valid) {
    // Before the oldest sample kept, Around answers with that sample twice.
    out.X_BT = Interpolate(before, after, std::max(t_ns, before.t_ns));
  } else if (out.valid) {
    out.X_BT = before_valid ? Predict(before, t_ns) : MotionOf(after);
  }
  return out;
}

}  // namespace omni::layer
