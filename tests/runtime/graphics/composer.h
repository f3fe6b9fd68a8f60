#pragma once
// What a person would see of a frame: its projection and quad layers, one over the other, as saved pictures.

#include <openxr/openxr.h>

#include "tests/runtime/state.h"

namespace omni::runtime {

// With OMNI_TEST_RUNTIME_PICTURES=FOLDER, of the first frame of a session that has layers and of every tenth after it:
// FOLDER/left.png, right.png, and then frame.txt with the number of that frame and of its layers. Each file is replaced
// as a whole. Precondition: CheckFrameLayers found nothing wrong. XR_ERROR_RUNTIME_FAILURE: an image could not be read,
// or a file not written.
XrResult SavePictures(const World& world, Session& session, const XrFrameEndInfo& info);

}  // namespace omni::runtime
