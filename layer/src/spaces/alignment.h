// Where the base stands in the headset's space, as the service knows it.
#pragma once

#include <mutex>
#include <optional>

#include "layer/src/instance/runtime.h"
#include "layer/src/instance/session.h"
#include "service/protocol/messages.h"

namespace omni::layer {

class Alignment {
 public:
  Alignment(const Runtime& runtime, const Records& records, ServiceLink& link, const RuntimeClock& clock, Log& log)
      : runtime_(runtime), records_(records), link_(link), clock_(clock), log_(log) {}

  void RequestBasePose(Session& session, XrSystemId system);
  // Handles the service's answers, if any. Called wherever the socket is polled.
  void Poll();
  void OnSpaceChange(XrEventDataReferenceSpaceChangePending change);

 private:
  bool ReportChange(const XrEventDataReferenceSpaceChangePending& change);

  const Runtime& runtime_;
  const Records& records_;
  ServiceLink& link_;
  const RuntimeClock& clock_;
  Log& log_;
  std::mutex mutex_;
  std::optional<protocol::BasePose> placed_;  // the service's last message
};

}  // namespace omni::layer
