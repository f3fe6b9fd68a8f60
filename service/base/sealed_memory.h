// Memory files (memfd) that one process makes and another maps: sized, filled and sealed before they are shared, and
// mapped only after checking the seals, which guarantee that they can neither shrink under the reader (SIGBUS) nor be
// resealed. Set-up only: allocates and makes system calls.
#pragma once

#include <fcntl.h>

#include <cstddef>
#include <string_view>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::base {

// Seals (memfd_create(2)): the size is final and no seal can be added; both sides may write.
inline constexpr int kSealsFixedSize = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
// Only the creator's mapping can write.
inline constexpr int kSealsOneWriter = kSealsFixedSize | F_SEAL_FUTURE_WRITE;

// Owns a mapping and unmaps it on destruction.
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
// pages are allocated now: lack of memory is an error here, not a SIGBUS later.
Result<SealedMemory> MakeSealedMemory(const char* name, std::size_t bytes, int protection, int seals);

// An immutable copy of `content`: not even its creator can change it.
Result<UniqueFd> SealedCopy(const char* name, std::string_view content);

// Checks that memory of another process has all of `seals` and exactly `bytes`. The error continues a sentence that
// starts with the memory's name: "lacks the seals F_SEAL_GROW".
Status CheckSealed(int fd, int seals, std::size_t bytes);

// The same, mapped with `protection`.
Result<Mapping> MapSealed(int fd, int seals, std::size_t bytes, int protection);

}  // namespace omni::base
