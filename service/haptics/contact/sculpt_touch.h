// Contacts on sculpted surfaces: rebound when the surface has changed, and handed to the tool that grabs it.
// docs/theory/sculpting.md, sections 5 and 6.
#pragma once

#include "service/haptics/contact/contact_force.h"

namespace omni::haptics {

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
