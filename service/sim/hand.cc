#include "service/sim/hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::sim {
namespace {

// Minimum jerk [Flash, Hogan 1985]: s = 10 x^3 - 15 x^4 + 6 x^5 on x in [0, 1], at rest on both ends.
double MinimumJerk(double x) noexcept { return x * x * x * (10 + x * (6 * x - 15)); }
double MinimumJerkSlope(double x) noexcept { return 30 * x * x * (1 - x) * (1 - x); }

constexpr double kTremorMin_Hz = 8, kTremorMax_Hz = 12;
constexpr double kHullMargin_m = 1e-9;  // over rounding
constexpr HandWaypoint kNobody{0, {0, 0, 0.2}, {0, 0, -1}, false};

}  // namespace

HandPath::HandPath(const HandScript& script, double tip_offset_m, Random& random) : tip_offset_m_(tip_offset_m) {
  const std::vector<HandWaypoint>& points = script.waypoints;
  if (points.empty()) AddLeg(kNobody, kNobody, 0);
  if (points.size() == 1) AddLeg(points.front(), points.front(), 0);
  for (std::size_t i = 1; i < points.size(); ++i) AddLeg(points[i - 1], points[i], points[i].duration_s);
  if (script.repeat && points.size() > 1) {
    AddLeg(points.back(), points.front(), points.front().duration_s);
    period_s_ = legs_.back().start_s + legs_.back().duration_s;
  }
  // Three waves per direction; rms of the sum is tremor_m.
  const double amplitude_m = script.tremor_m * std::sqrt(2.0 / static_cast<double>(tremor_.size()));
  for (std::size_t i = 0; i < tremor_.size(); ++i) {
    tremor_[i].rate_rad_s = 2 * std::numbers::pi * random.Uniform(kTremorMin_Hz, kTremorMax_Hz);
    tremor_[i].phase_rad = 2 * std::numbers::pi * random.Uniform();
    const std::array<Vec3, 3> directions{Vec3{amplitude_m, 0, 0}, Vec3{0, amplitude_m, 0}, Vec3{0, 0, amplitude_m}};
    tremor_[i].amplitude_m = directions[i % 3];
  }
}

void HandPath::AddLeg(const HandWaypoint& from, const HandWaypoint& to, double duration_s) {
  Leg leg;
  if (!legs_.empty()) leg.start_s = legs_.back().start_s + legs_.back().duration_s;
  leg.duration_s = duration_s;
  leg.from_tip = from.tip_base_m;
  leg.to_tip = to.tip_base_m;
  leg.from_axis = Normalised(from.axis_base);
  leg.present = to.present;
  const Vec3 to_axis = Normalised(to.axis_base);
  const double cosine = std::clamp(Dot(leg.from_axis, to_axis), -1.0, 1.0);
  const Vec3 across = to_axis - cosine * leg.from_axis;
  const double sine = Norm(across);
  leg.angle_rad = std::atan2(sine, cosine);
  // Equal axes do not turn; opposite ones turn about any perpendicular.
  leg.turn_axis = sine > 1e-9 ? (1 / sine) * across : Perpendicular(leg.from_axis);
  legs_.push_back(leg);
}

HandTarget HandPath::At(double t_s) const noexcept {
  const double t = period_s_ > 0 ? std::fmod(t_s, period_s_) : t_s;
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
  for (const Wave& wave : tremor_) {
    const double phase = wave.rate_rad_s * t_s + wave.phase_rad;
    target.centre_base_m += std::sin(phase) * wave.amplitude_m;
    target.velocity_base_m_s += (wave.rate_rad_s * std::cos(phase)) * wave.amplitude_m;
  }
  return target;
}

Hand::Hand(const HandScript& script, const base::DeviceGeometry& device, Random& random)
    : path_(script, device.magnet.tip_offset_m, random),
      magnet_(device.magnet),
      hull_radius_m_(device.hull_radius_m),
      stiffness_N_m_(script.stiffness_N_m),
      damping_Ns_m_(script.damping_Ns_m),
      mass_kg_(script.mass_kg) {
  const HandTarget start = path_.At(0);
  pose_ = {start.centre_base_m, start.axis_base};
  velocity_ = start.velocity_base_m_s;
  present_ = start.present;
  KeepOutOfHull();
}

// Semi-implicit Euler; its stability limits, k dt^2 < 4 m and c dt < m, are kept by the ranges of HandScript.
void Hand::Step(double t_s, double dt_s, const Vec3& force_N) noexcept {
  const HandTarget target = path_.At(t_s + dt_s);
  t_s_ = t_s + dt_s;
  pose_.axis_base = target.axis_base;
  present_ = target.present;
  if (!target.present) {  // carried out of reach: nothing acts, the pen is where the script says
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

MagnetPose Hand::Predicted(double t_s) const noexcept {
  MagnetPose pose{pose_.centre_base_m + (t_s - t_s_) * velocity_, path_.At(t_s).axis_base};
  const Gap gap = GapToHull(magnet_, hull_radius_m_, pose);
  if (gap.gap_m < 0) pose.centre_base_m += -gap.gap_m * gap.normal_base;
  return pose;
}

}  // namespace omni::sim
