#include "layer/src/own_functions.h"

namespace omni::layer {

// A table a file of entry points: appended here.
const std::vector<OwnFunction>& OwnFunctions() {
  static const std::vector<OwnFunction> all;
  return all;
}

}  // namespace omni::layer
