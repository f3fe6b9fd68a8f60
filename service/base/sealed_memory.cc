#include "service/base/sealed_memory.h"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace omni::base {
namespace {

struct SealName {
  int seal;
  const char* name;
};
constexpr SealName kSealNames[] = {{F_SEAL_WRITE, "F_SEAL_WRITE"},
                                   {F_SEAL_SEAL, "F_SEAL_SEAL"},
                                   {F_SEAL_SHRINK, "F_SEAL_SHRINK"},
                                   {F_SEAL_GROW, "F_SEAL_GROW"},
                                   {F_SEAL_FUTURE_WRITE, "F_SEAL_FUTURE_WRITE"}};

std::string NamesOfSeals(int seals) {
  std::string names;
  for (const SealName& row : kSealNames) {
    if ((seals & row.seal) != 0) names += std::string(" ") + row.name;
  }
  return names;
}

Error MakingFailed(const char* name, const char* step) {
  const int error = errno;
  return Error{std::string("shared memory ") + name + ": " + step + " failed: " + std::strerror(error) +
               "; check the limits on memory and open files (ulimit -a)"};
}

bool WriteContent(int fd, std::string_view content) noexcept {
  while (!content.empty()) {
    const ssize_t written = ::write(fd, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

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

void* Mapping::Release() noexcept { return std::exchange(memory_, nullptr); }

Result<SealedMemory> MakeSealedMemory(const char* name, std::size_t bytes, int protection, int seals) {
  UniqueFd fd(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!fd) return MakingFailed(name, "memfd_create");
  if (::ftruncate(fd.get(), static_cast<off_t>(bytes)) != 0) return MakingFailed(name, "ftruncate");
  if (::fallocate(fd.get(), 0, 0, static_cast<off_t>(bytes)) != 0) return MakingFailed(name, "fallocate");
  void* memory = ::mmap(nullptr, bytes, protection, MAP_SHARED | MAP_POPULATE, fd.get(), 0);
  if (memory == MAP_FAILED) return MakingFailed(name, "mmap");
  Mapping mapping(memory, bytes);
  if (::fcntl(fd.get(), F_ADD_SEALS, seals) != 0) return MakingFailed(name, "F_ADD_SEALS");
  return SealedMemory{std::move(fd), std::move(mapping)};
}

Result<UniqueFd> SealedCopy(const char* name, std::string_view content) {
  UniqueFd fd(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!fd) return MakingFailed(name, "memfd_create");
  if (!WriteContent(fd.get(), content)) return MakingFailed(name, "write");
  if (::fcntl(fd.get(), F_ADD_SEALS, kSealsOneWriter | F_SEAL_WRITE) != 0) return MakingFailed(name, "F_ADD_SEALS");
  return fd;
}

Status CheckSealed(int fd, int seals, std::size_t bytes) {
  const auto failed = [](const char* what) { return Error{what + std::string(std::strerror(errno))}; };
  const int present = ::fcntl(fd, F_GET_SEALS);
  if (present < 0) return failed("is not sealable memory: ");
  if ((present & seals) != seals) return Error{"lacks the seals" + NamesOfSeals(seals & ~present)};
  struct stat info {};
  if (::fstat(fd, &info) != 0) return failed("cannot be examined: ");
  if (info.st_size != static_cast<off_t>(bytes)) {
    return Error{"has " + std::to_string(info.st_size) + " bytes, must have " + std::to_string(bytes)};
  }
  return Ok{};
}

Result<Mapping> MapSealed(int fd, int seals, std::size_t bytes, int protection) {
  if (const Status checked = CheckSealed(fd, seals, bytes); !checked.ok()) return Error{checked.error()};
  void* memory = ::mmap(nullptr, bytes, protection, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) return Error{"cannot be mapped: " + std::string(std::strerror(errno))};
  return Mapping(memory, bytes);
}

}  // namespace omni::base
