#include "service/client/sealed_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace omni::client {
namespace {

struct SealName {
  int seal;
  const char* name;
};
constexpr SealName kSealNames[] = {{F_SEAL_SEAL, "F_SEAL_SEAL"},
                                   {F_SEAL_SHRINK, "F_SEAL_SHRINK"},
                                   {F_SEAL_GROW, "F_SEAL_GROW"},
                                   {F_SEAL_FUTURE_WRITE, "F_SEAL_FUTURE_WRITE"}};

std::string MissingSeals(int missing) {
  std::string names;
  for (const SealName& row : kSealNames) {
    if ((missing & row.seal) != 0) names += std::string(" ") + row.name;
  }
  return names;
}

}  // namespace

SealedMapping MapSealed(int fd, int seals, std::size_t bytes, int protection) {
  const int present = ::fcntl(fd, F_GET_SEALS);
  if (present < 0) return {nullptr, std::string("is no sealable memory: ") + std::strerror(errno)};
  if ((present & seals) != seals) return {nullptr, "lacks the seals" + MissingSeals(seals & ~present)};
  struct stat info {};
  if (::fstat(fd, &info) != 0) return {nullptr, std::string("cannot be examined: ") + std::strerror(errno)};
  if (info.st_size != static_cast<off_t>(bytes)) {
    return {nullptr, "has " + std::to_string(info.st_size) + " bytes, must have " + std::to_string(bytes)};
  }
  void* memory = ::mmap(nullptr, bytes, protection, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) return {nullptr, std::string("cannot be mapped: ") + std::strerror(errno)};
  return {memory, {}};
}

}  // namespace omni::client
