// Which features a loaded scene uses: each on or off, and why.
#pragma once

#include <string>
#include <vector>

#include "service/tools/scene/scene_source.h"

namespace omni::tools {

struct SceneFeature {
  std::string name;  // at most 10 characters
  bool on = false;
  std::string why;
};

// In a fixed order, all of them: also for the empty scene of an untagged file.
std::vector<SceneFeature> FeaturesOf(const LoadedScene& loaded);

}  // namespace omni::tools
