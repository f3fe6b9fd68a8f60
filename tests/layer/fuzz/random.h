// Seeded choices of a fuzzed call sequence. Equal seeds give equal sequences on every machine.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace omni::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  std::uint64_t Bits() { return engine_(); }
  std::uint32_t Below(std::uint32_t n) { return static_cast<std::uint32_t>(engine_() % n); }
  bool Percent(std::uint32_t p) { return Below(100) < p; }
  double Unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  template <class T>
  const T& Of(const std::vector<T>& values) {
    return values[Below(static_cast<std::uint32_t>(values.size()))];
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace omni::test
