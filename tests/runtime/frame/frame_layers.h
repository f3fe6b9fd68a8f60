#pragma once
// The layers that an application passes to xrEndFrame: checked, and recorded for the tests.

#include "tests/runtime/hooks.h"
#include "tests/runtime/state.h"

namespace omni::runtime {

// Spaces of this session, types that are enabled, unit orientations; images (sub_images.h).
XrResult CheckFrameLayers(const Session& session, const XrFrameEndInfo& info);

// The newest frame that came down, accepted or not. The caller holds the state exclusively.
void RecordFrame(const XrFrameEndInfo& info);
const OmniTestFrame& RecordedFrame();
void ForgetFrame();

}  // namespace omni::runtime
