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

// Tangential force on the tool. Sets the anchor if the contact has none, moves it when slipping. Defined for Surface
// and sculpt::SculptSurface.
template <MeshView View>
Vec3 FrictionForce(const View& view, const FrictionInput& input, ContactState& contact) noexcept;

// Where the anchor is now; precondition: contact.anchor_triangle is set.
template <MeshView View>
Vec3 AnchorPosition(const View& view, const ContactState& contact) noexcept {
  const Corners c = view.TriangleCorners(contact.anchor_triangle);
  return contact.anchor_weights[0] * c[0] + contact.anchor_weights[1] * c[1] + contact.anchor_weights[2] * c[2];
}

}  // namespace omni::haptics
