// Stick-slip friction with an anchor on the surface. docs/theory/haptics.md, section 5.
#pragma once

#include "service/haptics/contact/proxy.h"

namespace omni::haptics {

// What the contact is now, before friction.
struct FrictionInput {
  Vec3 proxy;
  Vec3 normal;  // unit, in the direction of the normal force
  std::uint32_t proxy_triangle = kNoIndex;
  double normal_force_N = 0;
  double stiffness_N_m = 0;  // tangential, at most the normal one
  double static_friction = 0;
  double dynamic_friction = 0;
};

// Tangential force on the tool. Sets the anchor if the contact has none, moves it when slipping.
Vec3 FrictionForce(const Surface& surface, const FrictionInput& input, ContactState& contact) noexcept;

// Where the anchor is now; precondition: contact.anchor_triangle is set.
Vec3 AnchorPosition(const Surface& surface, const ContactState& contact) noexcept;

}  // namespace omni::haptics
