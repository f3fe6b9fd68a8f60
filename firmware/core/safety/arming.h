// Arming in two steps: a request is answered with a nonce, and returning it within 100 ms arms, once.
#pragma once

#include <cstdint>

namespace omni::firmware {

class Arming {
 public:
  // `seed`: must differ at every reset, or nonces repeat.
  explicit Arming(std::uint32_t seed) noexcept : state_(seed) {}

  std::uint32_t Challenge(std::uint64_t now_us) noexcept;
  // Right or wrong, the nonce is used up.
  bool Confirm(std::uint32_t nonce, std::uint64_t now_us) noexcept;

 private:
  std::uint32_t state_;
  std::uint32_t nonce_ = 0;
  std::uint64_t asked_us_ = 0;
  bool is_open_ = false;
};

}  // namespace omni::firmware
