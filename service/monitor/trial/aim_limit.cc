#include "service/monitor/trial/trial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "service/base/vec.h"

namespace omni::monitor {
namespace {

// The limit follows the edge at which the base just makes all: quickly back, slowly on.
constexpr double kBack_N_s = 2, kOn_N_s = 0.5;
// A soft body may give way to less than the base's force: deeper than this a pen comes out of a thin part elsewhere.
constexpr double kDeepest_m = 0.0075;
// A mouse is moved faster than a hand presses, which would overshoot all that.
constexpr double kPress_m_s = 0.02, kPressFirst_m = 0.003;
// A pen that bounces is still held back.
constexpr double kBounce_s = 0.2;
constexpr double kSteep = 0.5;  // cosine

using base::VecOf;

}  // namespace

void AimLimit::Update(const protocol::ToolSample& tool, const protocol::ContactSnapshot& contacts, double dt_s) {
  const double most_m = options_.force_max_N / options_.hand_stiffness_N_m;
  const bool touches = (tool.flags & protocol::kToolTracked) != 0 && contacts.count > 0;
  away_s_ = touches ? 0 : away_s_ + dt_s;
  if (!touches && contacts_.count > 0 && away_s_ < kBounce_s) return;
  contacts_ = touches ? contacts : protocol::ContactSnapshot{};
  if (!touches) {
    beyond_m_ = most_m;
    pressed_m_ = 0;
    cut_ = false;
    return;
  }
  // Where the surface is without the pen: that of a soft body is seen where it is dented.
  const base::Vec3 tip_m = VecOf(tool.position_base_m);
  double deepest_m = 0;
  for (std::uint32_t i = 0; i < contacts.count; ++i) {
    protocol::ContactSample& contact = contacts_.contacts[i];
    deepest_m = std::max(deepest_m, contact.penetration_m);
    const base::Vec3 rest_m = tip_m + contact.penetration_m * VecOf(contact.normal_base);
    contact.point_base_m = {rest_m.x, rest_m.y, rest_m.z};
  }
  pressed_m_ = std::max(pressed_m_ + kPress_m_s * dt_s, deepest_m + kPressFirst_m);
  const double force_N = Norm(VecOf(tool.force_base_N));
  soft_m_ = kDeepest_m + force_N / options_.hand_stiffness_N_m;
  const bool cut = (tool.flags & (protocol::kToolForceCut | protocol::kToolOutOfReach)) != 0;
  if (cut && !cut_) {
    cut_ = true;
    beyond_m_ = std::min(beyond_m_, force_N / options_.hand_stiffness_N_m + deepest_m);
  }
  const double change_N = (cut ? -kBack_N_s : cut_ ? kOn_N_s : 0) * dt_s;
  beyond_m_ = std::clamp(beyond_m_ + change_N / options_.hand_stiffness_N_m, 0.0, most_m);
}

double AimLimit::beyond_m() const {
  return contacts_.count > 0 ? std::min({beyond_m_, soft_m_, pressed_m_}) : std::numeric_limits<double>::infinity();
}

// (p - aim) . n <= beyond for every contact: point p, normal n. The pen is drawn back along its own axis, so that it
// stays over the place that it was led to; where that lies along the surface, along the normal.
protocol::HandAim AimLimit::LimitAim(const protocol::HandAim& aim) const {
  base::Vec3 tip_m = VecOf(aim.tip_base_m);
  const base::Vec3 back = -1.0 * Normalized(VecOf(aim.axis_base));
  for (std::uint32_t i = 0; i < contacts_.count; ++i) {
    const base::Vec3 normal = VecOf(contacts_.contacts[i].normal_base);
    const double excess_m = Dot(VecOf(contacts_.contacts[i].point_base_m) - tip_m, normal) - beyond_m();
    const double along = Dot(back, normal);
    if (excess_m > 0) tip_m = along > kSteep ? tip_m + (excess_m / along) * back : tip_m + excess_m * normal;
  }
  protocol::HandAim limited = aim;
  limited.tip_base_m = {tip_m.x, tip_m.y, tip_m.z};
  return limited;
}

}  // namespace omni::monitor
