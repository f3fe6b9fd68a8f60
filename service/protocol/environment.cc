#include "service/protocol/environment.h"

#include <sys/auxv.h>

#include <cstdlib>

namespace omni::protocol {

bool IsPrivileged() noexcept { return ::getauxval(AT_SECURE) != 0; }

std::string Environment(const char* name) {
  const char* value = ::secure_getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace omni::protocol
