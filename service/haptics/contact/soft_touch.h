// Contacts on soft bodies: the body's reaction to the depths of all contacts on it. docs/theory/deformable.md.
#pragma once

#include "service/haptics/contact/contact_scene.h"
#include "service/haptics/deformable/soft_contact.h"

namespace omni::haptics {

// A contact as its body sees it, in its rest frame.
struct SoftPress {
  Vec3 normal;               // unit, out of the body
  double depth_m = 0;        // of the tip under the rest surface, along `normal`
  double stiffness_N_m = 0;  // of the contact's spring, in series with the body; > 0
};

// Of the ball that presses a body or a layer: the tip's, or kIndenterRadius_m for a point.
double PressRadius_m(const ContactScene& contact_scene) noexcept;

// Direction of the body's reaction, out of the surface, and depth of the real tip   (deformable.md 8.1).
SoftPress PressOf(const ContactScene& contact_scene, const Target& target, const ContactState& contact) noexcept;

// Normal forces of the contacts of `object`, by slot; `press[k]` counts for active contacts of the object.
std::array<SoftForce, kMaxContacts> SoftForcesOf(const ContactScene& contact_scene, std::uint32_t object,
                                                 const std::array<SoftPress, kMaxContacts>& press, double dt_s,
                                                 State& state) noexcept;

// Where the proxy is on the deformed surface, in the frame of the rest.
Vec3 DeformedProxy(const ContactScene& contact_scene, const ContactState& contact, const State& state) noexcept;

}  // namespace omni::haptics
