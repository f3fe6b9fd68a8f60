// What omni monitor and omni try have in common.
#pragma once

#include <string>

#include "service/base/result.h"

namespace omni::tools {

// The folder of the page's files. The error says that they were not built, and what works without.
base::Result<std::string> FindPage();

// Opens an address in the user's browser, if there is one and a display to show it on. False: there is not.
bool OpenBrowser(const std::string& address);

}  // namespace omni::tools
