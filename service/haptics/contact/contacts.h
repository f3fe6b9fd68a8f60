// What a tick does with contacts: which objects are touched, what force that gives, and what becomes of contacts on
// surfaces that are being sculpted. docs/theory/haptics.md, sections 2 to 6; sculpting.md, sections 5 and 6.
#pragma once

#include "service/haptics/contact/contact_scene.h"
#include "service/haptics/contact/proxy.h"
#include "service/haptics/stability/stability.h"

namespace omni::haptics {

// Starts, follows and ends contacts (contact_set.cc)   (2).

// The tip has just appeared: objects it is inside of become contacts at the nearest point of their surface. If it is
// the scene that has appeared, they act only after the tip was outside: a body does not push away a pen that it came
// to.
void StartContacts(const ContactScene& contact_scene, State& state) noexcept;

// The tip moved: follows every contact, and starts those with what the motion entered or what was moved over the tip.
void UpdateContacts(const ContactScene& contact_scene, double dt_s, State& state) noexcept;

// The same of a tip that is a ball: one contact per object, held by the ball's centre (ball/ball_touch.cc)   (12).

// The tip has just appeared: objects it overlaps become contacts.
void StartBalls(const ContactScene& contact_scene, State& state) noexcept;

// The tip moved: every ball follows it.
void UpdateBalls(const ContactScene& contact_scene, double dt_s, State& state) noexcept;

// From a contact to a force: stiffness, damping and the models of effects.h (contact_force.cc)   (3 to 6).
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

// Forces of all active contacts. Contacts that pop through are marked or dropped.
ContactForces ForcesOf(const StiffnessBound& bound, const ContactScene& contact_scene, const Input& input,
                       State& state) noexcept;

// Contacts on sculpted surfaces: rebound when the surface has changed, and handed to the tool that grabs it
// (sculpt_touch.cc)   (sculpting.md, 5 and 6).

// Force of the contacts on objects that have changed, as it was rendered at the last tick, base frame.
Vec3 ForceOnChanged(const ContactScene& contact_scene, const State& state) noexcept;

// Before contacts are followed: puts those on surfaces that have changed onto the new ones.
void RebindContacts(const ContactScene& contact_scene, State& state) noexcept;

// After they were followed: the force they rendered (`before_N`, ForceOnChanged before rebinding) but no longer do,
// because the surface left the tip, fades out.
void StartLeaving(const ContactScene& contact_scene, const Vec3& before_N, State& state) noexcept;
Vec3 FadeLeaving(double dt_s, State& state) noexcept;

// After the contacts' forces are known: steps the tool of every sculpt session. Scales the contact forces of a surface
// that is held and returns the tools' own, base frame.
Vec3 StepSculptTools(const StiffnessBound& bound, const ContactScene& contact_scene, const Input& input,
                     ContactForces& forces, State& state) noexcept;

// False: a tool is active or has messages for its editor, and must be stepped even while nothing is touched.
bool ToolsRest(const Scene& scene, const State& state) noexcept;
// The tools rest, and the surfaces are those of the last tick. Acknowledges these to their editors.
bool SurfacesRest(const Scene& scene, const State& state) noexcept;

}  // namespace omni::haptics
