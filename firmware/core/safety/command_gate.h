// Which COMMAND may act: newer than all before it, and within its time to live. Sequence numbers wrap after a minute,
// so the command's host clock is checked as well. docs/theory/firmware.md (8.1), (8.2)
#pragma once

#include "firmware/wire/messages.h"

namespace omni::firmware {

class CommandGate {
 public:
  // False: a duplicate, a replay or late. `now_us`: of the previous step, so that lives end early rather than late.
  bool Accept(const wire::Command& command, std::uint16_t seq, std::uint64_t now_us) noexcept;

  // For a new host, or one that was disconnected: any sequence may begin.
  void Forget() noexcept { has_order_ = false; }
  // On arming: the first command may take a whole time to live.
  void StartWaiting(std::uint64_t now_us) noexcept;

  bool is_alive(std::uint64_t now_us) const noexcept { return has_life_ && now_us - heard_us_ <= live_us_; }

  std::uint16_t seq() const noexcept { return seq_; }
  std::uint64_t host_us() const noexcept { return host_us_; }
  std::uint64_t heard_us() const noexcept { return heard_us_; }

 private:
  bool has_order_ = false;
  bool has_life_ = false;
  std::uint16_t seq_ = 0;
  std::uint64_t host_us_ = 0;
  std::uint64_t heard_us_ = 0;
  std::uint64_t live_us_ = 0;
};

}  // namespace omni::firmware
