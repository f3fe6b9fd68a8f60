// Frames waiting to be sent: answers in order, then the newest telemetry. When full, the newest answer is lost and
// counted; the host repeats its request.
#pragma once

#include "firmware/wire/messages.h"

namespace omni::firmware {

class Outbox {
 public:
  template <class Message>
  void Push(const Message& message) noexcept {
    if (count_ == kAnswersMax) {
      ++lost_;
      return;
    }
    Answer& answer = answers_[(first_ + count_) % kAnswersMax];
    std::uint8_t frame[kAnswerSizeMax];
    const wire::Encoded encoded = wire::Encode(message, 0, 0, frame, sizeof frame);
    if (encoded.status != wire::Status::kOk) {  // a number that is not finite: must not be sent
      ++lost_;
      return;
    }
    answer.type = Message::kType;
    answer.size = encoded.size - wire::kHeaderSize - wire::kTrailerSize;
    for (std::size_t i = 0; i < answer.size; ++i) answer.payload[i] = frame[wire::kHeaderSize + i];
    ++count_;
  }

  // False: the previous one was not fetched and is replaced.
  bool PushTelemetry(const wire::Telemetry& telemetry, std::uint64_t t_device_us) noexcept;

  // The next frame; 0: none. One that does not fit is lost.
  std::size_t PopFrame(std::uint64_t now_us, std::uint8_t* frame, std::size_t capacity) noexcept;

  std::uint32_t lost() const noexcept { return lost_; }

 private:
  static constexpr int kAnswersMax = 8;
  static constexpr std::size_t kAnswerSizeMax = wire::FrameSize<wire::Log>();
  static_assert(wire::FrameSize<wire::Hello>() <= kAnswerSizeMax &&
                    wire::FrameSize<wire::FaultEvent>() <= kAnswerSizeMax,
                "LOG is the largest answer");

  struct Answer {
    wire::MessageType type = wire::MessageType::kLog;
    std::size_t size = 0;
    std::uint8_t payload[kAnswerSizeMax] = {};
  };

  Answer answers_[kAnswersMax];
  int first_ = 0;
  int count_ = 0;
  wire::Telemetry telemetry_;
  std::uint64_t telemetry_us_ = 0;
  bool has_telemetry_ = false;
  std::uint16_t seq_ = 0;
  std::uint32_t lost_ = 0;
};

}  // namespace omni::firmware
