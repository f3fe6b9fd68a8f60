// TickOutput -> state memory: the tick thread's only way out to clients.
#pragma once

#include "service/ipc/state_publisher.h"
#include "service/loop/telemetry.h"

namespace omni::daemon {

class PublishSink : public loop::TickSink {
 public:
  explicit PublishSink(ipc::StatePublisher& publisher) : publisher_(publisher) {}
  void Publish(const loop::TickOutput& output) noexcept override;

 private:
  ipc::StatePublisher& publisher_;
};

}  // namespace omni::daemon
