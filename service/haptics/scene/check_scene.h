// Whether bytes that come from elsewhere (a cache file, another process) are a scene that the tick can use: every
// offset, index, count and value in range. Set-up only.
#pragma once

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

// `scene` may hold any bytes; until this returns Ok, call nothing but block(). Errors are clauses: "has a damaged
// tree".
base::Status CheckScene(const Scene& scene);

}  // namespace omni::haptics
