// Whether a shared library can be opened and exports a function, checked as the OpenXR loader does.
#pragma once

#include <string>

namespace omni::tools {

// Empty: both hold. The library is opened in this process and closed again.
std::string LibraryProblem(const std::string& library, const std::string& function);

}  // namespace omni::tools
