// The way of the tick's messages to the editor: a lock-free ring.
#pragma once

#include "service/base/spsc_ring.h"
#include "service/haptics/sculpt/stroke_message.h"

namespace omni::haptics::sculpt {

// The tick sends at most one message a tick: half a second.
using StrokeRing = base::SpscRing<StrokeMessage, 512>;

}  // namespace omni::haptics::sculpt
