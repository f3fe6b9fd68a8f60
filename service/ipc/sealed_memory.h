// Memory files (memfd) that are passed to clients: sized, mapped and sealed before anybody else sees them.
#pragma once

#include <cstddef>
#include <string_view>

#include "service/base/result.h"
#include "service/protocol/unique_fd.h"

namespace omni::ipc {

// A mapping that is undone at the end of its owner's life.
class Mapping {
 public:
  Mapping() = default;
  Mapping(void* memory, std::size_t bytes) noexcept : memory_(memory), bytes_(bytes) {}
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();

  void* get() const noexcept { return memory_; }

 private:
  void* memory_ = nullptr;
  std::size_t bytes_ = 0;
};

struct SealedMemory {
  protocol::UniqueFd fd;
  Mapping mapping;
};

// Zeroed memory of `bytes`, mapped with `protection`, then sealed with `seals` (F_SEAL_*). `name` shows in /proc.
base::Result<SealedMemory> MakeSealedMemory(const char* name, std::size_t bytes, int protection, int seals);

// Memory that holds `content` (not empty) and that nobody can change any more.
base::Result<protocol::UniqueFd> MemoryWith(const char* name, std::string_view content);

}  // namespace omni::ipc
