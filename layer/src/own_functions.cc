#include "layer/src/own_functions.h"

#include "layer/src/entry_automation.h"

namespace omni::layer {

// A table a file of entry points: appended here.
const std::vector<OwnFunction>& OwnFunctions() {
  static const std::vector<OwnFunction> all = [] {
    std::vector<OwnFunction> out;
    const auto append = [&out](const std::vector<OwnFunction>& table) {
      out.insert(out.end(), table.begin(), table.end());
    };
    append(AutomationFunctions());
    return out;
  }();
  return all;
}

}  // namespace omni::layer
