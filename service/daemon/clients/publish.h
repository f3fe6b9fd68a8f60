// TickOutput -> state memory: the tick thread's only path to clients.
#pragma once

#include <atomic>

#include "service/ipc/state_publisher.h"
#include "service/loop/telemetry.h"

namespace omni::daemon {

class PublishSink : public loop::TickSink {
 public:
  explicit PublishSink(ipc::StatePublisher& publisher) : publisher_(publisher) {}
  void Publish(const loop::TickOutput& output, const base::HallScan& scan,
               const loop::TickTimes& times) noexcept override;
  // Any thread: whether the base's place in the headset's space is measured.
  void SetAligned(bool aligned) noexcept { aligned_.store(aligned, std::memory_order_relaxed); }

 private:
  ipc::StatePublisher& publisher_;
  std::atomic<bool> aligned_{false};
};

}  // namespace omni::daemon
