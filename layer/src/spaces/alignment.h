// Where the base stands in the headset's space, as the service knows it.
#pragma once

#include <mutex>
#include <optional>

#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/instance/session.h"
#include "service/protocol/messages.h"

namespace omni::layer {

class Instance;

class Alignment {
 public:
  explicit Alignment(Instance& instance) : instance_(instance) {}

  void RequestBasePose(Session& session, XrSystemId system);
  // Handles the service's answers, if any. Called wherever the socket is polled.
  void Poll();
  void OnSpaceChange(XrEventDataReferenceSpaceChangePending change);

 private:
  bool ReportChange(const XrEventDataReferenceSpaceChangePending& change);

  Instance& instance_;
  std::mutex mutex_;
  std::optional<protocol::BasePose> placed_;  // the service's last message
};

}  // namespace omni::layer
