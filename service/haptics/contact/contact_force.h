// From a contact to a force: stiffness, damping, softness, friction and effects. docs/theory/haptics.md, sections 3-6.
#pragma once

#include "service/haptics/contact/contact_scene.h"
#include "service/haptics/stability/stability.h"

namespace omni::haptics {

struct ContactForce {
  Vec3 force_N;
  double elastic_N = 0;  // normal force without damping and effects
  double depth_m = 0;
  double stiffness_cut = 1;  // rendered / requested stiffness
  double asked_stiffness_N_m = 0;
  Contact report;
};

struct ContactForces {
  std::array<ContactForce, kMaxContacts> of{};  // by slot of State::contacts
};

// Forces of all active contacts. `last_proxy_m[k]`: proxy of slot k one tick ago. Contacts that pop through are marked
// or dropped.
ContactForces ForcesOf(const StiffnessBound& bound, const ContactScene& contact_scene, const Input& input,
                       const std::array<Vec3, kMaxContacts>& last_proxy_m, State& state) noexcept;

}  // namespace omni::haptics
