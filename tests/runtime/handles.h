#pragma once
// Handle = kind | generation | slot. A handle that was destroyed, or is of another type, or never was one, finds
// nothing; slots are used again, handles never are (2^24 generations).

#include <cstdint>
#include <memory>
#include <vector>

#include "tests/runtime/objects.h"

namespace omni::runtime {

class Handles {
 public:
  // Gives the object its handle.
  uint64_t Insert(std::shared_ptr<Object> object);
  void Erase(uint64_t handle);
  uint32_t live() const { return live_; }

  template <class T, class Handle>
  T* Find(Handle handle) const {
    return static_cast<T*>(Lookup(Bits(handle), T::kKind));
  }

  template <class T, class Handle>
  std::shared_ptr<T> Share(Handle handle) const {
    const uint64_t bits = Bits(handle);
    if (Lookup(bits, T::kKind) == nullptr) return nullptr;
    return std::static_pointer_cast<T>(slots_[static_cast<uint32_t>(bits)].object);
  }

  template <class Handle>
  static uint64_t Bits(Handle handle) {
    return reinterpret_cast<uint64_t>(handle);
  }
  template <class Handle>
  static Handle As(uint64_t bits) {
    return reinterpret_cast<Handle>(bits);
  }

 private:
  struct Entry {
    uint32_t generation = 0;
    std::shared_ptr<Object> object;
  };

  Object* Lookup(uint64_t bits, Kind kind) const {
    const uint32_t index = static_cast<uint32_t>(bits);
    if (index >= slots_.size()) return nullptr;
    Object* const object = slots_[index].object.get();
    return object != nullptr && object->handle == bits && object->kind == kind ? object : nullptr;
  }

  std::vector<Entry> slots_;
  std::vector<uint32_t> free_;
  uint32_t live_ = 0;
};

}  // namespace omni::runtime
