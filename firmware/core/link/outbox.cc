#include "firmware/core/link/outbox.h"

#include <cstring>

namespace omni::firmware {

bool Outbox::PushTelemetry(const wire::Telemetry& telemetry, std::uint64_t t_device_us) noexcept {
  const bool was_fetched = !has_telemetry_;
  telemetry_ = telemetry;
  telemetry_us_ = t_device_us;
  has_telemetry_ = true;
  return was_fetched;
}

// Sequence numbers are assigned when a frame leaves, so that they are in sending order.
std::size_t Outbox::PopFrame(std::uint64_t now_us, std::uint8_t* frame, std::size_t capacity) noexcept {
  wire::Encoded encoded;
  if (count_ > 0) {
    const Answer& answer = answers_[first_];
    first_ = (first_ + 1) % kAnswersMax;
    --count_;
    if (capacity < wire::kHeaderSize + answer.size + wire::kTrailerSize) {
      ++lost_;
      return 0;
    }
    std::memcpy(frame + wire::kHeaderSize, answer.payload, answer.size);
    wire::Header header;
    header.type = answer.type;
    header.seq = seq_;
    header.t_device_us = now_us;
    encoded = wire::SealFrame(header, answer.size, frame, capacity);
  } else if (has_telemetry_) {
    has_telemetry_ = false;
    encoded = wire::Encode(telemetry_, seq_, telemetry_us_, frame, capacity);
  } else {
    return 0;
  }
  if (encoded.status != wire::Status::kOk) {
    ++lost_;
    return 0;
  }
  ++seq_;
  return encoded.size;
}

}  // namespace omni::firmware
