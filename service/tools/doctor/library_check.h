// Whether a shared library can be opened and has a function, as the OpenXR loader would find out.
#pragma once

#include <string>

namespace omni::tools {

// Empty: it can and has. The library is opened in this process and closed again.
std::string LibraryProblem(const std::string& library, const std::string& function);

}  // namespace omni::tools
