#include "service/haptics/vehicle/joystick.h"

namespace omni::haptics {

// F = -K (|u| - dead)+ u/|u| - b v: no spring inside the dead zone, continuous at its edge   (7.1)
Vec3 JoystickForce(const JoystickInput& joystick, const Offer& offer, const Input& input) noexcept {
  const double stiffness_N_m = std::clamp(joystick.stiffness_N_m, 0.0, offer.stiffness_N_m);
  const double damping_Ns_m = std::clamp(joystick.damping_Ns_m, 0.0, offer.damping_Ns_m);
  const Vec3 u = input.device_point_base_m - joystick.centre_base_m;
  const double stretch_m = std::max(0.0, Norm(u) - joystick.dead_zone_m);
  return -stiffness_N_m * stretch_m * Normalized(u) - damping_Ns_m * input.velocity_base_m_s;
}

// Only the lateral displacement counts: (|u_xy| - dead) / (range - dead), at most 1   (7.2)
Thumbstick JoystickDeflection(const JoystickInput& joystick, const Vec3& tip) noexcept {
  const double x = tip.x - joystick.centre_base_m.x;
  const double y = tip.y - joystick.centre_base_m.y;
  const double r = std::sqrt(x * x + y * y);
  const double travel_m = joystick.range_m - joystick.dead_zone_m;
  if (!(r > joystick.dead_zone_m && travel_m > 0)) return {};
  const double deflection = std::min(1.0, (r - joystick.dead_zone_m) / travel_m);
  return {deflection * x / r, deflection * y / r};
}

}  // namespace omni::haptics
