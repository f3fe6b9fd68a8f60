#include "layer/src/own_functions.h"

#include "layer/src/haptic_functions.h"

namespace omni::layer {

// A table a file of entry points: appended here.
const std::vector<OwnFunction>& OwnFunctions() {
  static const std::vector<OwnFunction> all = [] {
    std::vector<OwnFunction> joined;
    for (const auto* functions : {&HapticFunctions()}) {
      joined.insert(joined.end(), functions->begin(), functions->end());
    }
    return joined;
  }();
  return all;
}

}  // namespace omni::layer
