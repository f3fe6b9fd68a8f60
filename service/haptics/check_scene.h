// Whether bytes that come from elsewhere (a cache file, another process) are a scene that the tick can use: every
// offset, index, count and value in range. Set-up only.
#pragma once

#include "service/base/result.h"
#include "service/haptics/scene.h"

namespace omni::haptics {

// `scene` is made of any bytes; only after this gave no error may anything but block() be asked of it. Errors say what
// is wrong, as a clause: "has a damaged tree".
base::Status CheckScene(const Scene& scene);

}  // namespace omni::haptics
