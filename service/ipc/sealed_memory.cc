#include "service/ipc/sealed_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace omni::ipc {

Mapping::Mapping(Mapping&& other) noexcept
    : memory_(std::exchange(other.memory_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}

Mapping& Mapping::operator=(Mapping&& other) noexcept {
  std::swap(memory_, other.memory_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

Mapping::~Mapping() {
  if (memory_ != nullptr) ::munmap(memory_, bytes_);
}

base::Result<SealedMemory> MakeSealedMemory(const char* name, std::size_t bytes, int protection, int seals) {
  const auto failed = [name](const char* step) {
    return base::Error{std::string("shared memory ") + name + ": " + step + " failed: " + std::strerror(errno) +
                       "; check the limits on memory and open files (ulimit -a)"};
  };
  protocol::UniqueFd fd(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!fd) return failed("memfd_create");
  if (::ftruncate(fd.get(), static_cast<off_t>(bytes)) != 0) return failed("ftruncate");
  // The pages are taken now: a full machine is an error here, not a SIGBUS in the tick or in a client.
  if (::fallocate(fd.get(), 0, 0, static_cast<off_t>(bytes)) != 0) return failed("fallocate");
  void* memory = ::mmap(nullptr, bytes, protection, MAP_SHARED | MAP_POPULATE, fd.get(), 0);
  if (memory == MAP_FAILED) return failed("mmap");
  Mapping mapping(memory, bytes);
  if (::fcntl(fd.get(), F_ADD_SEALS, seals) != 0) return failed("F_ADD_SEALS");
  return SealedMemory{std::move(fd), std::move(mapping)};
}

base::Result<protocol::UniqueFd> MemoryWith(const char* name, std::string_view content) {
  base::Result<SealedMemory> made = MakeSealedMemory(name, content.size(), PROT_READ | PROT_WRITE,
                                                     F_SEAL_FUTURE_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL);
  if (!made.ok()) return base::Error{made.error()};
  std::memcpy(made->mapping.get(), content.data(), content.size());
  return std::move(made->fd);  // our mapping, the only one that could write, ends here
}

}  // namespace omni::ipc
