#include "service/monitor/trial/aim_limit.h"

#include <algorithm>
#include <cmath>

#include "service/base/vec.h"

namespace omni::monitor {
namespace {

// The limit follows the edge at which the base just makes all: quickly back, slowly on.
constexpr double kBack_N_s = 2, kOn_N_s = 0.5;

base::Vec3 VecOf(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

void AimLimit::Feel(const protocol::ToolSample& tool, const protocol::ContactSnapshot& contacts, double dt_s) {
  const double most_m = options_.force_max_N / options_.hand_stiffness_N_m;
  const bool touches = (tool.flags & protocol::kToolTracked) != 0 && contacts.count > 0;
  contacts_ = touches ? contacts : protocol::ContactSnapshot{};
  if (!touches) {
    beyond_m_ = most_m;
    cut_ = false;
    return;
  }
  const bool cut = (tool.flags & (protocol::kToolSaturated | protocol::kToolOutOfReach)) != 0;
  if (cut && !cut_) {
    cut_ = true;
    double deepest_m = 0;
    for (std::uint32_t i = 0; i < contacts.count; ++i) {
      deepest_m = std::max(deepest_m, contacts.contacts[i].penetration_m);
    }
    const double force_N = Norm(VecOf(tool.force_base_N));
    beyond_m_ = std::min(beyond_m_, force_N / options_.hand_stiffness_N_m + deepest_m);
  }
  const double change_N = (cut ? -kBack_N_s : cut_ ? kOn_N_s : 0) * dt_s;
  beyond_m_ = std::clamp(beyond_m_ + change_N / options_.hand_stiffness_N_m, 0.0, most_m);
}

// (p - aim) . n <= beyond for every contact: point p, normal n.
protocol::HandAim AimLimit::Limited(const protocol::HandAim& aim) const {
  base::Vec3 tip_m = VecOf(aim.tip_base_m);
  for (std::uint32_t i = 0; i < contacts_.count; ++i) {
    const base::Vec3 normal = VecOf(contacts_.contacts[i].normal_base);
    const double excess_m = Dot(VecOf(contacts_.contacts[i].point_base_m) - tip_m, normal) - beyond_m_;
    if (excess_m > 0) tip_m = tip_m + excess_m * normal;
  }
  protocol::HandAim limited = aim;
  limited.tip_base_m = {tip_m.x, tip_m.y, tip_m.z};
  return limited;
}

}  // namespace omni::monitor
