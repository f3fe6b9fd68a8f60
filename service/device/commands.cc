#include "service/device/commands.h"

namespace omni::device {
namespace {

bool OfOthers(std::uint32_t faults) noexcept { return (faults & ~wire::kFaultsOfTheHost) != 0; }

constexpr double kMax_us = 50'000;  // longer: the command's life had ended long before
// Share of the distance to a later or an earlier answer: in balance about 1 % of the answers are later.
constexpr double kRise = 0.05, kFall = 0.0005;

}  // namespace

void Arming::Rest(std::int64_t until_ns) noexcept {
  phase_ = Phase::kRest;
  not_before_ns_ = until_ns;
}

void Arming::OnTelemetry(const wire::Telemetry& telemetry, std::int64_t t_ns) noexcept {
  armed_ = telemetry.state == wire::State::kArmed && telemetry.faults == 0;
  held_ = held_ || OfOthers(telemetry.faults);
  if (armed_ || held_) {
    Rest(0);
    return;
  }
  const bool ready = telemetry.state == wire::State::kIdle || telemetry.state == wire::State::kFault;
  if (phase_ != Phase::kRest && t_ns - since_ns_ > kAnswer_ns) Rest(t_ns);
  if (phase_ == Phase::kRest && ready && t_ns >= not_before_ns_) {
    phase_ = Phase::kAsk;
    since_ns_ = t_ns;
  }
}

bool Arming::OnArm(const wire::Arm& arm, std::int64_t t_ns) noexcept {
  if (arm.step == wire::ArmStep::kChallenge && phase_ == Phase::kAsked) {
    nonce_ = arm.nonce;
    phase_ = Phase::kConfirm;
    return true;
  }
  if (arm.step == wire::ArmStep::kArmed && phase_ == Phase::kConfirmed) return true;  // telemetry reports it, too
  const bool asked = phase_ == Phase::kAsked || phase_ == Phase::kConfirmed;
  if (arm.step == wire::ArmStep::kRefused && asked) {
    // A running self-test refuses, too; a failed one shows in the telemetry.
    held_ = held_ || OfOthers(arm.faults & ~wire::kFaultSelfTest);
    Rest(t_ns + kPause_ns);
    return true;
  }
  return false;
}

bool Arming::NextToSend(std::int64_t t_ns, wire::Arm& arm) noexcept {
  if (phase_ != Phase::kAsk && phase_ != Phase::kConfirm) return false;
  arm = {};
  arm.step = phase_ == Phase::kAsk ? wire::ArmStep::kRequest : wire::ArmStep::kConfirm;
  arm.nonce = phase_ == Phase::kAsk ? 0 : nonce_;
  phase_ = phase_ == Phase::kAsk ? Phase::kAsked : Phase::kConfirmed;
  since_ns_ = t_ns;
  return true;
}

void ResponseTime::OnSent(std::uint16_t seq, std::uint64_t t_device_us) noexcept {
  sent_[seq % kKept] = {seq, true, t_device_us};
}

void ResponseTime::OnTelemetry(const wire::Telemetry& telemetry) noexcept {
  Sent& sent = sent_[telemetry.ack_seq % kKept];
  if (!sent.waits || sent.seq != telemetry.ack_seq) return;
  sent.waits = false;
  const std::uint32_t response_us = telemetry.ack_rx_device_us - static_cast<std::uint32_t>(sent.t_device_us);
  const double us = response_us;
  if (!(us <= kMax_us)) return;
  late_us_ += late_us_ == 0 ? us : (us - late_us_) * (us > late_us_ ? kRise : kFall);
}

}  // namespace omni::device
