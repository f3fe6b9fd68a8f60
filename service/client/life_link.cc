#include "service/client/life_link.h"

#include <sys/mman.h>

#include "service/base/sealed_memory.h"

namespace omni::client {
namespace {

void* MapPrivate() noexcept {
  return ::mmap(nullptr, protocol::kLifePageBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
}

// The mapping at `from` replaces the one at `onto` in one step: a thread that writes there meanwhile hits either page.
bool Move(void* from, void* onto) noexcept {
  const int flags = MREMAP_MAYMOVE | MREMAP_FIXED;
  if (::mremap(from, protocol::kLifePageBytes, protocol::kLifePageBytes, flags, onto) == onto) return true;
  ::munmap(from, protocol::kLifePageBytes);
  return false;
}

}  // namespace

LifeLink::LifeLink() : page_(&fallback_) {
  void* memory = MapPrivate();
  if (memory != MAP_FAILED) page_ = static_cast<protocol::LifePage*>(memory);
}

LifeLink::~LifeLink() {
  if (page_ != &fallback_) ::munmap(page_, protocol::kLifePageBytes);
}

std::string LifeLink::Attach(int fd) {
  if (page_ == &fallback_) return "cannot be mapped: no address was reserved for it";
  auto mapping = base::MapSealed(fd, base::kSealsFixedSize, protocol::kLifePageBytes, PROT_READ | PROT_WRITE);
  if (!mapping.ok()) return mapping.error();
  return Move(mapping->Release(), page_) ? std::string() : "cannot be put in place";
}

void LifeLink::Detach() noexcept {
  if (page_ == &fallback_) return;
  void* page = MapPrivate();
  if (page != MAP_FAILED) Move(page, page_);  // else beats go on to a page that no process reads
}

}  // namespace omni::client
