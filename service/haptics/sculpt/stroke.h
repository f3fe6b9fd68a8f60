// Carries the tick's messages to the editor: a lock-free ring.
#pragma once

#include "service/base/spsc_ring.h"
#include "service/haptics/sculpt/stroke_message.h"

namespace omni::haptics::sculpt {

// At most one message per tick: room for half a second.
using StrokeRing = base::SpscRing<StrokeMessage, 512>;

}  // namespace omni::haptics::sculpt
