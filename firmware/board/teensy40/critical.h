// A stretch that no interrupt enters; nests. For a bus that the control interrupt and the main loop share.
#pragma once

#include <cstdint>

namespace omni::board {

class Critical {
 public:
  Critical() noexcept {
    asm volatile("mrs %0, primask" : "=r"(before_));
    asm volatile("cpsid i" ::: "memory");
  }
  ~Critical() { asm volatile("msr primask, %0" ::"r"(before_) : "memory"); }
  Critical(const Critical&) = delete;
  Critical& operator=(const Critical&) = delete;

 private:
  std::uint32_t before_;
};

}  // namespace omni::board
