// Asks the OpenXR loader of this machine which layers it finds.
#pragma once

#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

// Opens libopenxr_loader.so.1, as an application would, with the environment of this process; no runtime is started.
LoaderAnswer QueryLoader();

}  // namespace omni::tools
