#include "service/device/response_time.h"

namespace omni::device {
namespace {

constexpr double kMax_us = 50'000;  // longer: the command's life had ended long before
// Share of the distance to a later or an earlier answer: in balance about 1 % of the answers are later.
constexpr double kRise = 0.05, kFall = 0.0005;

}  // namespace

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
