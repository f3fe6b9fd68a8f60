#pragma once
// Where a space is at a time.

#include <openxr/openxr.h>

#include "tests/runtime/state.h"

namespace omni::runtime {

struct Located {
  bool valid = false;
  bool tracked = false;
  Motion motion;  // in the world
  Source source;  // action spaces: what they follow
};

Located Locate(const World& world, Session& session, const Space& space, XrTime time);

// `space` in `base`. Two spaces on the same source are rigidly joined: known even when the source is not tracked.
Located LocateIn(const World& world, Session& session, const Space& space, const Space& base, XrTime time);

}  // namespace omni::runtime
