// Memory files (memfd) that one process makes and another maps: sized, filled and sealed before anybody else sees them,
// mapped only once their seals prove that they can neither shrink under the reader (SIGBUS) nor change their rules.
// Set-up only: allocates and makes system calls.
#pragma once

#include <fcntl.h>

#include <cstddef>
#include <string_view>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::base {

// Seals (memfd_create(2)): the size is final and no seal can be added; both sides may write.
inline constexpr int kSealsFixedSize = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
// Only the mapping that its maker has can write.
inline constexpr int kSealsOneWriter = kSealsFixedSize | F_SEAL_FUTURE_WRITE;

// A mapping that is undone at the end of its owner's life.
class Mapping {
 public:
  Mapping() = default;
  Mapping(void* memory, std::size_t bytes) noexcept : memory_(memory), bytes_(bytes) {}
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();

  void* get() const noexcept { return memory_; }
  void* Release() noexcept;

 private:
  void* memory_ = nullptr;
  std::size_t bytes_ = 0;
};

struct SealedMemory {
  UniqueFd fd;
  Mapping mapping;
};

// Zeroed memory of `bytes`, mapped with `protection` (PROT_*), then sealed with `seals`. `name` shows in /proc. The
// pages are taken now: a full machine is an error here, not a SIGBUS later.
Result<SealedMemory> MakeSealedMemory(const char* name, std::size_t bytes, int protection, int seals);

// A copy of `content` that nobody can change any more, including its maker.
Result<UniqueFd> SealedCopy(const char* name, std::string_view content);

// Memory that another process made has all of `seals` and exactly `bytes`. The error reads on from the memory's name:
// "lacks the seals F_SEAL_GROW".
Status CheckSealed(int fd, int seals, std::size_t bytes);

// The same, mapped with `protection`.
Result<Mapping> MapSealed(int fd, int seals, std::size_t bytes, int protection);

}  // namespace omni::base
