// Contacts on sculpted surfaces: found again when the surface was changed, and given to the tool that takes hold of it.
// docs/theory/sculpting.md, sections 5 and 6.
#pragma once

#include "service/haptics/contact/contact_force.h"

namespace omni::haptics {

// Force of the contacts on objects that have changed, as it was rendered at the last tick, base frame.
Vec3 ForceOnChanged(const ContactScene& contact_scene, const State& state) noexcept;

// Before contacts are followed: puts those on surfaces that have changed onto the new ones.
void RebindContacts(const ContactScene& contact_scene, State& state) noexcept;

// After they were followed: what they rendered (`before_N`, ForceOnChanged before rebinding) and do no more, because
// the surface has gone from under the tip, fades out.
void StartLeaving(const ContactScene& contact_scene, const Vec3& before_N, State& state) noexcept;
Vec3 FadeLeaving(double dt_s, State& state) noexcept;

// After the contacts' forces are known: steps the tool of every workshop. Scales the contact forces of a surface that
// is held and returns the tools' own, base frame.
Vec3 StepSculptTools(const StiffnessBound& bound, const ContactScene& contact_scene, const Input& input,
                     ContactForces& forces, State& state) noexcept;

// A tool is at work or has something to say to its editor: it must be stepped though nothing is touched.
bool ToolsRest(const Scene& scene, const State& state) noexcept;
// The tools rest, and the surfaces are those that the tick took last. Tells their editors that it still holds these.
bool SurfacesRest(const Scene& scene, const State& state) noexcept;

}  // namespace omni::haptics
