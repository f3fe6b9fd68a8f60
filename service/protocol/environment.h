// Variables of the environment, for the layer and for clients, which run inside of other people's programs.
//
// A privileged process (set-uid, set-gid, file capabilities: AT_SECURE, getauxval(3)) has more rights than whoever
// started it, and whoever started it has chosen its environment. There no variable counts.
#pragma once

#include <string>

namespace omni::protocol {

bool IsPrivileged() noexcept;

// Empty: not set, set to nothing, or this process is privileged.
std::string Environment(const char* name);

}  // namespace omni::protocol
