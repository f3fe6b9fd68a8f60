// Environment variables, for the layer and for clients, which run inside of other people's programs.
//
// A privileged process (set-uid, set-gid, file capabilities: AT_SECURE, getauxval(3)) has more rights than the user who
// started it and chose its environment. It ignores all of these variables.
#pragma once

#include <sys/auxv.h>

#include <cstdlib>
#include <string>

namespace omni::protocol {

inline bool IsPrivileged() noexcept { return ::getauxval(AT_SECURE) != 0; }

// Empty: not set, set to nothing, or this process is privileged.
inline std::string EnvironmentVariable(const char* name) {
  const char* value = ::secure_getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace omni::protocol
