#include "firmware/core/safety/output_check.h"

#include "firmware/core/safety/fault_rules.h"

namespace omni::firmware {

bool OutputCheck::Allows(const Outputs& outputs) noexcept {
  const bool is_ramp = left_steps_ > 0;
  if (is_ramp) --left_steps_;
  if (state_ == wire::State::kArmed) left_steps_ = kRamp_steps;
  if (is_ramp || state_ == wire::State::kArmed || state_ == wire::State::kSelfTest) return true;
  for (const std::int16_t duty : outputs.duty) {
    if (duty != 0) return false;
  }
  return true;
}

}  // namespace omni::firmware
