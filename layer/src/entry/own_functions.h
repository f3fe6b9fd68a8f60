// The functions of extensions that only this layer implements.
#pragma once

#include <vector>

#include "layer/src/entry/dispatch.h"

namespace omni::layer {

const std::vector<OwnFunction>& OwnFunctions();

}  // namespace omni::layer
