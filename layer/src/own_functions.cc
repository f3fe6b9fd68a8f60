#include "layer/src/own_functions.h"

#include <initializer_list>

#include "layer/src/entry_automation.h"
#include "layer/src/haptic_functions.h"

namespace omni::layer {
namespace {

std::vector<OwnFunction> Joined(std::initializer_list<const std::vector<OwnFunction>*> tables) {
  std::vector<OwnFunction> all;
  for (const auto* table : tables) all.insert(all.end(), table->begin(), table->end());
  return all;
}

}  // namespace

// A table a file of entry points: appended here.
const std::vector<OwnFunction>& OwnFunctions() {
  static const std::vector<OwnFunction> all = Joined({
      &AutomationFunctions(),
      &ForceFeedbackFunctions(),
      &HapticFunctions(),
      &HapticSceneFunctions(),
  });
  return all;
}

}  // namespace omni::layer
