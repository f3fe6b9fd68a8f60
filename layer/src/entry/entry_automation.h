// The functions of XR_EXT_conformance_automation: docs/howto/openxr-layer.md, "Conformance tests".
#pragma once

#include <vector>

#include "layer/src/entry/dispatch.h"

namespace omni::layer {

const std::vector<OwnFunction>& AutomationFunctions();

}  // namespace omni::layer
