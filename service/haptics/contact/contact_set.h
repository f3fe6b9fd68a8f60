// Which objects are touched: takes contacts on, follows them, lets them go. docs/theory/haptics.md, section 2.
#pragma once

#include "service/haptics/contact/contact_scene.h"
#include "service/haptics/contact/proxy.h"

namespace omni::haptics {

// The tip has just appeared: objects it is inside of become contacts at the nearest point of their surface.
void StartContacts(const ContactScene& contact_scene, State& state) noexcept;

// The tip moved: follows every contact, takes on what the motion entered, and what was changed over the tip.
void UpdateContacts(const ContactScene& contact_scene, double dt_s, State& state) noexcept;

}  // namespace omni::haptics
