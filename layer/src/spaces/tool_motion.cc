#include "layer/src/spaces/tool_motion.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

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

// Measured by the tracker, with enough certainty.
bool Tracked(const protocol::ToolSample& s) noexcept {
  return Has(s, protocol::kToolPoseValid) && Has(s, protocol::kToolTracked) && s.position_sigma_m <= kMaxTrackedSigma_m;
}

}  // namespace

Motion Interpolate(const Motion& m0, std::int64_t t0_ns, const Motion& m1, std::int64_t t1_ns,
                   std::int64_t t_ns) noexcept {
  const double h = 1e-9 * static_cast<double>(t1_ns - t0_ns);
  const double s = 1e-9 * static_cast<double>(t_ns - t0_ns) / h;
  // Hermite basis: p(s) = h00 p0 + h10 h v0 + h01 p1 + h11 h v1, v = dp/ds / h
  const double s2 = s * s;
  const double s3 = s2 * s;
  Motion m;
  m.X.p =
      (2 * s3 - 3 * s2 + 1) * m0.X.p + (s3 - 2 * s2 + s) * h * m0.v + (3 * s2 - 2 * s3) * m1.X.p + (s3 - s2) * h * m1.v;
  m.X.q = glm::slerp(m0.X.q, m1.X.q, s);
  // The tracker's own velocities, which it filters. The derivative of p(s) would have the positions' noise over h.
  m.v = (1 - s) * m0.v + s * m1.v;
  m.w = (1 - s) * m0.w + s * m1.w;
  return m;
}

Motion Interpolate(const protocol::ToolSample& before, const protocol::ToolSample& after, std::int64_t t_ns) noexcept {
  if (after.t_ns <= before.t_ns) return MotionOf(after);
  return Interpolate(MotionOf(before), before.t_ns, MotionOf(after), after.t_ns, t_ns);
}

namespace {

// Share of a velocity that is deliberate motion, not tremor.
double Share(double mean, double rest) noexcept { return mean * mean / (mean * mean + rest * rest); }

double AngleBetween(const glm::dquat& a, const glm::dquat& b) noexcept {
  const glm::dquat turn = glm::conjugate(a) * b;
  return 2.0 * std::atan2(glm::length(glm::dvec3(turn.x, turn.y, turn.z)), std::abs(turn.w));
}

// Removes the untrusted share of the velocities in `m`.
void TrustVelocities(const protocol::ToolSample& newest, const protocol::ToolSample& earlier, Motion& m) noexcept {
  double speed_m_s = glm::length(m.v);
  double turn_rad_s = glm::length(m.w);
  const std::int64_t span_ns = newest.t_ns - earlier.t_ns;
  if (Has(earlier, protocol::kToolPoseValid) && span_ns >= kTrendMin_ns && span_ns <= kTrendMax_ns) {
    const Motion before = MotionOf(earlier);
    const double span_s = 1e-9 * static_cast<double>(span_ns);
    speed_m_s = glm::length(m.X.p - before.X.p) / span_s;
    turn_rad_s = AngleBetween(before.X.q, m.X.q) / span_s;
  }
  m.v *= Share(speed_m_s, kRestSpeed_m_s);
  m.w *= Share(turn_rad_s, kRestTurn_rad_s);
}

}  // namespace

Motion Predict(const protocol::ToolSample& newest, const protocol::ToolSample& earlier, std::int64_t t_ns,
               Prediction method) noexcept {
  Motion m = MotionOf(newest);
  if (method == Prediction::kHold) return m;
  if (method == Prediction::kTrusted) TrustVelocities(newest, earlier, m);
  const std::int64_t longest_ns = kMaxPrediction_ns;
  const double dt = 1e-9 * static_cast<double>(std::clamp<std::int64_t>(t_ns - newest.t_ns, 0, longest_ns));
  return MovedOn(m, dt);
}

namespace {

// The newest sample carried on.
ToolMotion FromNewest(const client::StateReader& reader, const protocol::ToolSample& newest,
                      std::int64_t t_ns) noexcept {
  ToolMotion out;
  out.valid = Has(newest, protocol::kToolPoseValid);
  out.tracked = Tracked(newest);
  if (!out.valid) return out;
  protocol::ToolSample earlier;
  if (!reader.ReadEarlier(kTrendSamples, earlier)) earlier = newest;
  out.X_BT = Predict(newest, earlier, t_ns);
  return out;
}

// From history. Samples without a pose say nothing; the oldest pose stands for all before it.
ToolMotion FromHistory(const protocol::ToolSample& before, const protocol::ToolSample& after,
                       std::int64_t t_ns) noexcept {
  const bool before_valid = Has(before, protocol::kToolPoseValid);
  const bool after_valid = Has(after, protocol::kToolPoseValid);
  const bool near = t_ns >= before.t_ns && t_ns - before.t_ns <= kMaxGap_ns && after.t_ns - t_ns <= kMaxGap_ns;
  ToolMotion out;
  out.valid = before_valid || after_valid;
  out.tracked = near && Tracked(before) && Tracked(after);
  if (before_valid && after_valid) {
    out.X_BT = Interpolate(before, after, std::max(t_ns, before.t_ns));
  } else if (out.valid) {
    out.X_BT = before_valid ? Predict(before, before, t_ns) : MotionOf(after);
  }
  return out;
}

}  // namespace

ToolMotion ToolMotionAt(const client::StateReader& reader, std::int64_t t_ns, std::int64_t now_ns) noexcept {
  protocol::ToolSample before;
  protocol::ToolSample after;
  if (!reader.ReadNewest(after) || now_ns - after.t_ns > kPresenceTimeout_ns) return {};
  if (t_ns >= after.t_ns) return FromNewest(reader, after, t_ns);
  return reader.ReadAround(t_ns, before, after) ? FromHistory(before, after, t_ns) : ToolMotion{};
}

}  // namespace omni::layer
