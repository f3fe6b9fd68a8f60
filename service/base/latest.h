// Latest<T>: hands the newest value from one writer thread to one reader thread; neither ever waits.
// A triple buffer: the writer owns one slot, the reader one, the third is exchanged atomically.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace omni::base {

template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  // Writer thread only.
  void Write(const T& value) noexcept {
    WriteWith([&value](T& slot) { slot = value; });
  }

  // The same without a copy of its own: `fill(T&)` is given the slot, with some older value in it.
  template <class Fill>
  void WriteWith(Fill&& fill) noexcept {
    fill(slots_[writer_]);
    const std::uint8_t previous =
        exchange_.exchange(static_cast<std::uint8_t>(writer_ | kFresh), std::memory_order_acq_rel);
    writer_ = previous & kIndex;
  }

  // Reader thread only. The reference stays valid and unchanged until the next Read().
  const T& Read() noexcept {
    if (exchange_.load(std::memory_order_relaxed) & kFresh) {
      const std::uint8_t previous = exchange_.exchange(reader_, std::memory_order_acq_rel);
      reader_ = previous & kIndex;
    }
    return slots_[reader_];
  }

 private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kIndex = 3;
  std::array<T, 3> slots_{};
  std::uint8_t writer_ = 0;
  std::uint8_t reader_ = 1;
  std::atomic<std::uint8_t> exchange_{2};
};

}  // namespace omni::base
