#include "service/sim/hand/hand.h"

#include <algorithm>
#include <cmath>

namespace omni::sim {
namespace {

// Minimum jerk [Flash, Hogan 1985]: s = 10 x^3 - 15 x^4 + 6 x^5 on x in [0, 1], at rest on both ends.
double MinimumJerk(double x) noexcept { return x * x * x * (10 + x * (6 * x - 15)); }
double MinimumJerkSlope(double x) noexcept { return 30 * x * x * (1 - x) * (1 - x); }

constexpr double kHullMargin_m = 1e-9;  // over rounding
constexpr HandWaypoint kNobody{0, {0, 0, 0.2}, {0, 0, -1}, false};

}  // namespace

HandPath::HandPath(const HandScript& script, double tip_offset_m, Random& random)
    : tip_offset_m_(tip_offset_m), tremor_(script.tremor_m, random, script.tremor_band) {
  const std::vector<HandWaypoint>& points = script.waypoints;
  if (points.empty()) AddLeg(kNobody, kNobody, 0);
  if (points.size() == 1) AddLeg(points.front(), points.front(), 0);
  for (std::size_t i = 1; i < points.size(); ++i) AddLeg(points[i - 1], points[i], points[i].duration_s);
  if (script.repeat && points.size() > 1) {
    AddLeg(points.back(), points.front(), points.front().duration_s);
    period_s_ = legs_.back().start_s + legs_.back().duration_s;
  }
}

void HandPath::AddLeg(const HandWaypoint& from, const HandWaypoint& to, double duration_s) {
  Leg leg;
  if (!legs_.empty()) leg.start_s = legs_.back().start_s + legs_.back().duration_s;
  leg.duration_s = duration_s;
  leg.from_tip = from.tip_base_m;
  leg.to_tip = to.tip_base_m;
  leg.from_axis = Normalized(from.axis_base);
  leg.present = to.present;
  const Vec3 to_axis = Normalized(to.axis_base);
  const double cosine = std::clamp(Dot(leg.from_axis, to_axis), -1.0, 1.0);
  const Vec3 across = to_axis - cosine * leg.from_axis;
  const double sine = Norm(across);
  leg.angle_rad = std::atan2(sine, cosine);
  // Equal axes do not turn; opposite ones turn about any perpendicular.
  leg.turn_axis = sine > 1e-9 ? (1 / sine) * across : Perpendicular(leg.from_axis);
  legs_.push_back(leg);
}

HandTarget HandPath::Start() const noexcept { return Still(0); }

HandTarget HandPath::TargetAt(double t_s) const noexcept {
  HandTarget target = Still(t_s);
  tremor_.AddTo(t_s, target.centre_base_m, target.velocity_base_m_s);
  return target;
}

HandTarget HandPath::Still(double t_s) const noexcept {
  const double t = std::max(0.0, period_s_ > 0 ? std::fmod(t_s, period_s_) : t_s);
  const auto after =
      std::upper_bound(legs_.begin(), legs_.end(), t, [](double time, const Leg& leg) { return time < leg.start_s; });
  const Leg& leg = after == legs_.begin() ? legs_.front() : *(after - 1);
  const double x = leg.duration_s > 0 ? std::clamp((t - leg.start_s) / leg.duration_s, 0.0, 1.0) : 1.0;
  const double s = MinimumJerk(x);
  const double rate = leg.duration_s > 0 ? MinimumJerkSlope(x) / leg.duration_s : 0.0;
  const double turn = leg.angle_rad * s;
  const Vec3 axis = std::cos(turn) * leg.from_axis + std::sin(turn) * leg.turn_axis;
  const Vec3 axis_rate = (leg.angle_rad * rate) * (std::cos(turn) * leg.turn_axis - std::sin(turn) * leg.from_axis);
  HandTarget target;
  target.axis_base = axis;
  target.present = leg.present;
  target.centre_base_m = leg.from_tip + s * (leg.to_tip - leg.from_tip) - tip_offset_m_ * axis;
  target.velocity_base_m_s = rate * (leg.to_tip - leg.from_tip) - tip_offset_m_ * axis_rate;
  return target;
}

Hand::Hand(const HandScript& script, const base::DeviceGeometry& device, Random& random, bool led)
    : path_(script, device.magnet.tip_offset_m, random),
      magnet_(device.magnet),
      hull_radius_m_(device.hull_radius_m),
      stiffness_N_m_(script.stiffness_N_m),
      damping_Ns_m_(script.damping_Ns_m),
      mass_kg_(script.mass_kg) {
  if (led) led_.emplace(path_.Start(), device.magnet.tip_offset_m);
  const HandTarget start = NextTarget(0, 0);
  pose_ = {start.centre_base_m, start.axis_base};
  velocity_ = start.velocity_base_m_s;
  present_ = start.present;
  KeepOutOfHull();
}

// At t + dt.
HandTarget Hand::NextTarget(double t_s, double dt_s) noexcept {
  if (!led_) return path_.TargetAt(t_s + dt_s);
  led_->Step(dt_s);
  HandTarget target = led_->Target();
  path_.tremor().AddTo(t_s + dt_s, target.centre_base_m, target.velocity_base_m_s);
  return target;
}

// Semi-implicit Euler; its stability limits, k dt^2 < 4 m and c dt < m, are kept by the ranges of HandScript.
void Hand::Step(double t_s, double dt_s, const Vec3& force_N) noexcept {
  const HandTarget target = NextTarget(t_s, dt_s);
  t_s_ = t_s + dt_s;
  pose_.axis_base = target.axis_base;
  present_ = target.present;
  if (!target.present) {  // carried out of reach: nothing acts, the pen is where the script has it
    pose_.centre_base_m = target.centre_base_m;
    velocity_ = target.velocity_base_m_s;
    KeepOutOfHull();
    return;
  }
  const Vec3 spring_N = stiffness_N_m_ * (target.centre_base_m - pose_.centre_base_m) +
                        damping_Ns_m_ * (target.velocity_base_m_s - velocity_);
  velocity_ += (dt_s / mass_kg_) * (spring_N + force_N);
  pose_.centre_base_m += dt_s * velocity_;
  KeepOutOfHull();
}

// Inelastic, frictionless stop: out along the normal, no speed left into the hull.
void Hand::KeepOutOfHull() noexcept {
  const Gap gap = GapToHull(magnet_, hull_radius_m_, pose_);
  if (gap.gap_m >= 0) return;
  pose_.centre_base_m += (kHullMargin_m - gap.gap_m) * gap.normal_base;
  const double inward = Dot(velocity_, gap.normal_base);
  if (inward < 0) velocity_ += -inward * gap.normal_base;
}

MagnetPose Hand::PredictedPose(double t_s) const noexcept {
  const Vec3 axis_base = led_ ? pose_.axis_base : path_.TargetAt(t_s).axis_base;
  MagnetPose pose{pose_.centre_base_m + (t_s - t_s_) * velocity_, axis_base};
  const Gap gap = GapToHull(magnet_, hull_radius_m_, pose);
  if (gap.gap_m < 0) pose.centre_base_m += -gap.gap_m * gap.normal_base;
  return pose;
}

}  // namespace omni::sim
