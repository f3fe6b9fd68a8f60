#include "layer/src/sealed_document.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace omni::layer {

protocol::UniqueFd SealedDocument(const std::uint8_t* content, std::size_t bytes) noexcept {
  protocol::UniqueFd fd(::memfd_create("omni-scene", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  while (fd && bytes > 0) {
    const ssize_t written = ::write(fd.get(), content, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return {};
    content += written;
    bytes -= static_cast<std::size_t>(written);
  }
  const int seals = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
  if (!fd || ::fcntl(fd.get(), F_ADD_SEALS, seals) != 0) return {};
  return fd;
}

}  // namespace omni::layer
