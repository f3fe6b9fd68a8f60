// One ball that touches a soft body.
#pragma once

#include "service/haptics/deformable/soft_contact.h"

namespace omni::support {

inline haptics::SoftForce StepSoftContact(const haptics::SoftBodyView& body, const haptics::SoftContact& contact,
                                          double ball_radius_m, double dt_s,
                                          haptics::SoftContactState& state) noexcept {
  haptics::SoftForce force;
  StepSoftContacts(body, {&contact, 1}, ball_radius_m, dt_s, state, {&force, 1});
  return force;
}

}  // namespace omni::support
