// The sculpted surfaces of a scene as a scene of their own, for saving.
#pragma once

#include "service/haptics/live/live_parts.h"

namespace omni::haptics::sculpt {

// Every sculpted object as it is now, open strokes included, with the materials it uses (without their images), in the
// base frame. Called by the thread that edits. Empty without sculpt sessions.
SceneInput SculptedScene(const Scene& scene, const LiveParts& live);

}  // namespace omni::haptics::sculpt
