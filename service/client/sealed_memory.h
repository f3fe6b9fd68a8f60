// Mapping of memory that another process made, once its seals prove that it can neither shrink under us (SIGBUS) nor
// change its rules.
#pragma once

#include <cstddef>
#include <string>

namespace omni::client {

struct SealedMapping {
  void* memory = nullptr;  // null: `problem` says why
  std::string problem;
};

// `seals`: the F_SEAL_* that must be present. `bytes`: the exact size that the file must have.
SealedMapping MapSealed(int fd, int seals, std::size_t bytes, int protection);

}  // namespace omni::client
