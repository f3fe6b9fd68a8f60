// Which objects are touched: starts, follows and ends contacts. docs/theory/haptics.md, section 2.
#pragma once

#include "service/haptics/contact/contact_scene.h"
#include "service/haptics/contact/proxy.h"

namespace omni::haptics {

// The tip has just appeared: objects it is inside of become contacts at the nearest point of their surface. If it is
// the scene that has appeared, they act only after the tip was outside: a body does not push away a pen that it came
// to.
void StartContacts(const ContactScene& contact_scene, State& state) noexcept;

// The tip moved: follows every contact, and starts those with what the motion entered or what was moved over the tip.
void UpdateContacts(const ContactScene& contact_scene, double dt_s, State& state) noexcept;

}  // namespace omni::haptics
