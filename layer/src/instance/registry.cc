#include "layer/src/instance/registry.h"

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <new>
#include <utility>

namespace omni::layer {

// Never destroyed: an application's threads may still call in while the process exits. Lives in static storage, so that
// an unloaded library leaves nothing behind.
Registry& Registry::Get() {
  alignas(Registry) static std::byte storage[sizeof(Registry)];
  static Registry* const registry = new (storage) Registry;
  return *registry;
}

void Registry::Add(std::shared_ptr<Instance> instance) {
  const std::unique_lock lock(mutex_);
  instances_.push_back(std::move(instance));
}

void Registry::AddAside(const AsideInstance& instance) {
  const std::unique_lock lock(mutex_);
  aside_.push_back(instance);
}

std::optional<AsideInstance> Registry::FindAside(XrInstance handle) const {
  const std::shared_lock lock(mutex_);
  for (const AsideInstance& aside : aside_)
    if (aside.handle == handle) return aside;
  return std::nullopt;
}

void Registry::Remove(XrInstance handle) {
  std::shared_ptr<Instance> last;  // dies outside of the lock
  const std::unique_lock lock(mutex_);
  std::erase_if(aside_, [handle](const AsideInstance& aside) { return aside.handle == handle; });
  if (aside_.empty()) aside_.shrink_to_fit();
  const auto it =
      std::find_if(instances_.begin(), instances_.end(), [&](const auto& i) { return i->runtime.handle == handle; });
  if (it == instances_.end()) return;
  last = std::move(*it);
  instances_.erase(it);
  if (instances_.empty()) instances_.shrink_to_fit();
}

std::shared_ptr<Instance> Registry::Find(XrInstance handle) const {
  const std::shared_lock lock(mutex_);
  for (const auto& instance : instances_)
    if (instance->runtime.handle == handle) return instance;
  return nullptr;
}

}  // namespace omni::layer
