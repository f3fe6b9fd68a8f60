// Contacts of a tip that is a ball: one per object, held by the ball's centre. docs/theory/haptics.md, section 12.
#pragma once

#include "service/haptics/contact/contact_scene.h"

namespace omni::haptics {

// The tip has just appeared: objects it overlaps become contacts.
void StartBalls(const ContactScene& contact_scene, State& state) noexcept;

// The tip moved: every ball follows it.
void UpdateBalls(const ContactScene& contact_scene, double dt_s, State& state) noexcept;

}  // namespace omni::haptics
