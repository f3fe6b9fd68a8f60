// The functions of extensions that this layer brings: nothing below knows them.
#pragma once

#include <vector>

#include "layer/src/entry/dispatch.h"

namespace omni::layer {

const std::vector<OwnFunction>& OwnFunctions();

}  // namespace omni::layer
