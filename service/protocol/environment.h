// Environment variables, for the layer and for clients, which run inside of other people's programs.
//
// A privileged process (set-uid, set-gid, file capabilities: AT_SECURE, getauxval(3)) has more rights than the user who
// started it and chose its environment. It ignores all of these variables.
#pragma once

#include <string>

namespace omni::protocol {

bool IsPrivileged() noexcept;

// Empty: not set, set to nothing, or this process is privileged.
std::string Environment(const char* name);

}  // namespace omni::protocol
