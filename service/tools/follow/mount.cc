#include "service/tools/follow/mount.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "service/protocol/text.h"

namespace omni::tools {
namespace {

base::Quat Scaled(const base::Quat& q, double by) { return {by * q.w, by * q.x, by * q.y, by * q.z}; }
double DotOf(const base::Quat& a, const base::Quat& b) { return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z; }

// In L: R_after R_before' turns by the vector w dt.
base::Vec3 TurnRate(const base::Quat& before, const base::Quat& after, double dt_s) {
  const alignment::Rigid turn = alignment::Compose({.orientation = after, .position_m = {}},
                                                   alignment::Inverse({.orientation = before, .position_m = {}}));
  base::Quat q = turn.orientation;
  if (q.w < 0) q = Scaled(q, -1);
  const base::Vec3 v{q.x, q.y, q.z};
  const double sine = base::Norm(v);
  const double angle = 2 * std::atan2(sine, q.w);
  return sine > 1e-12 ? (angle / (sine * dt_s)) * v : base::Vec3{};
}

}  // namespace

void SourceAtRest::Add(std::int64_t t_ns, const alignment::Rigid& X_LC) {
  if (count_ == 0) {
    first_ = X_LC;
    first_ns_ = t_ns;
  }
  last_ns_ = t_ns;
  ++count_;
  sum_m_ = sum_m_ + X_LC.position_m;
  const base::Quat q = Scaled(X_LC.orientation, DotOf(X_LC.orientation, first_.orientation) < 0 ? -1 : 1);
  sum_q_ = {sum_q_.w + q.w, sum_q_.x + q.x, sum_q_.y + q.y, sum_q_.z + q.z};
  moved_m_ = std::max(moved_m_, base::Distance(X_LC.position_m, first_.position_m));
  moved_rad_ = std::max(moved_rad_, alignment::Angle_rad(X_LC, first_));
}

base::Result<alignment::Rigid> SourceAtRest::Mean() const {
  if (!(moved_m_ <= kMostMotion_m && moved_rad_ <= kMostMotion_rad)) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "it moved by %.1f mm and %.1f deg within a second; keep the base at rest and repeat", 1e3 * moved_m_,
                  57.29577951308232 * moved_rad_);
    return base::Error{text};
  }
  return alignment::Rigid{.orientation = Scaled(sum_q_, 1 / std::sqrt(DotOf(sum_q_, sum_q_))),
                          .position_m = (1.0 / count_) * sum_m_};
}

alignment::Rigid MountOf(const alignment::Rigid& X_LC, const alignment::Rigid& X_LB) {
  return alignment::Compose(alignment::Inverse(X_LC), X_LB);
}

CarriedBase::CarriedBase(const Headset& headset, const alignment::Rigid& X_CB) : headset_(headset), X_CB_(X_CB) {}

protocol::BaseMotion CarriedBase::In(protocol::BaseState state) const {
  protocol::BaseMotion motion;
  motion.state = state;
  motion.space = headset_.space;
  protocol::SetField(motion.headset.runtime, headset_.runtime);
  protocol::SetField(motion.headset.system, headset_.system);
  return motion;
}

// v_B = v_C + w_C x (R_LC p_CB),   w_B = w_C
protocol::BaseMotion CarriedBase::MotionAt(const ProbeLine& line) {
  base::Vec3 v = line.velocity_m_s, w = line.turn_rate_rad_s;
  if (!line.moves && before_ && line.t_ns > before_->t_ns && line.t_ns - before_->t_ns <= kLongestStep_ns) {
    const double dt_s = 1e-9 * static_cast<double>(line.t_ns - before_->t_ns);
    v = (1 / dt_s) * (line.pose.position_m - before_->pose.position_m);
    w = TurnRate(before_->pose.orientation, line.pose.orientation, dt_s);
  }
  before_ = line;
  const alignment::Rigid X_LB = alignment::Compose(line.pose, X_CB_);
  const base::Vec3 at_base = v + Cross(w, X_LB.position_m - line.pose.position_m);
  protocol::BaseMotion motion = In(protocol::BaseState::kSeen);
  motion.t_ns = line.t_ns;
  const base::Quat& q = X_LB.orientation;
  motion.base_space = {.position_m = {X_LB.position_m.x, X_LB.position_m.y, X_LB.position_m.z},
                       .orientation_wxyz = {q.w, q.x, q.y, q.z}};
  motion.linear_velocity_m_s = {at_base.x, at_base.y, at_base.z};
  motion.angular_velocity_rad_s = {w.x, w.y, w.z};
  return motion;
}

}  // namespace omni::tools
