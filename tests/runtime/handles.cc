#include "tests/runtime/handles.h"

#include <utility>

namespace omni::runtime {

uint64_t Handles::Insert(std::shared_ptr<Object> object) {
  uint32_t index = 0;
  if (free_.empty()) {
    index = static_cast<uint32_t>(slots_.size());
    slots_.emplace_back();
  } else {
    index = free_.back();
    free_.pop_back();
  }
  Entry& entry = slots_[index];
  entry.generation = (entry.generation + 1) & 0xffffffU;
  object->handle = uint64_t{static_cast<uint8_t>(object->kind)} << 56 | uint64_t{entry.generation} << 32 | index;
  entry.object = std::move(object);
  ++live_;
  return entry.object->handle;
}

void Handles::Erase(uint64_t handle) {
  const uint32_t index = static_cast<uint32_t>(handle);
  if (index >= slots_.size() || slots_[index].object == nullptr || slots_[index].object->handle != handle) return;
  // The object may live on (an attached action); as a handle it is gone.
  slots_[index].object->handle = 0;
  slots_[index].object.reset();
  free_.push_back(index);
  --live_;
}

}  // namespace omni::runtime
