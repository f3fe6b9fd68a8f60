#include "service/sim/hand/hand_guide.h"

#include <algorithm>

namespace omni::sim {
namespace {

constexpr double kBandwidth_rad_s = 40;  // an arm follows what it sees up to some Hz: 2 / w late in steady motion
constexpr double kFastest_m_s = 0.5;
constexpr double kHardest_m_s2 = 20;
constexpr double kEnter_1_s = 6;       // a pen that enters: its speed over what is left of the way ...
constexpr double kEntered_m = 1.5e-3;  // ... until so much is left
constexpr double kFastestTurn_rad_s = 5;

Vec3 Clamped(const Vec3& v, double most) noexcept {
  const double size = Norm(v);
  return size > most ? (most / size) * v : v;
}

}  // namespace

LedPath::LedPath(const HandTarget& start, double tip_offset_m) noexcept
    : tip_offset_m_(tip_offset_m),
      tip_m_(start.centre_base_m + tip_offset_m * start.axis_base),
      axis_(start.axis_base) {
  aim_ = {.tip_base_m = tip_m_, .axis_base = axis_, .present = start.present};
}

void LedPath::SetAim(const HandAim& aim) noexcept {
  if (aim.present && !aim_.present) {
    tip_m_ = aim.tip_base_m + Vec3{0, 0, kEnterFrom_m};
    velocity_m_s_ = axis_rate_1_s_ = {};
    axis_ = aim.axis_base;
    enters_ = true;
  }
  aim_ = aim;
}

void LedPath::Step(double dt_s) noexcept {
  if (!aim_.present) return;
  StepTip(dt_s);
  StepAxis(dt_s);
}

// p'' = w^2 (aim - p) - 2 w p', critically damped: it never swings past an aim that rests.
void LedPath::StepTip(double dt_s) noexcept {
  constexpr double w = kBandwidth_rad_s;
  const Vec3 wanted_m_s2 = w * w * (aim_.tip_base_m - tip_m_) - 2 * w * velocity_m_s_;
  const double left_m = Norm(aim_.tip_base_m - tip_m_);
  enters_ = enters_ && left_m > kEntered_m;
  const double fastest_m_s = enters_ ? std::min(kFastest_m_s, kEnter_1_s * left_m) : kFastest_m_s;
  velocity_m_s_ = Clamped(velocity_m_s_ + dt_s * Clamped(wanted_m_s2, kHardest_m_s2), fastest_m_s);
  tip_m_ += dt_s * velocity_m_s_;
}

// Along the shortest arc, slower towards its end.
void LedPath::StepAxis(double dt_s) noexcept {
  const double cosine = std::clamp(Dot(axis_, aim_.axis_base), -1.0, 1.0);
  const Vec3 across = aim_.axis_base - cosine * axis_;
  const double sine = Norm(across);
  const double angle_rad = std::atan2(sine, cosine);
  // Opposite axes turn about any perpendicular.
  const Vec3 towards = sine > 1e-9 ? (1 / sine) * across : Perpendicular(axis_);
  const double turn_rad = std::min({angle_rad, kBandwidth_rad_s * angle_rad * dt_s, kFastestTurn_rad_s * dt_s});
  axis_rate_1_s_ = dt_s > 0 ? (turn_rad / dt_s) * towards : Vec3{};
  axis_ = Normalized(std::cos(turn_rad) * axis_ + std::sin(turn_rad) * towards);
}

HandTarget LedPath::Target() const noexcept {
  return {.centre_base_m = tip_m_ - tip_offset_m_ * axis_,
          .velocity_base_m_s = velocity_m_s_ - tip_offset_m_ * axis_rate_1_s_,
          .axis_base = axis_,
          .present = aim_.present};
}

}  // namespace omni::sim
