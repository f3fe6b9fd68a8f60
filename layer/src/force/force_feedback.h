// One XrForceFeedbackOMNIX1.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "layer/src/force/force_shapes.h"
#include "layer/src/force/force_state.h"
#include "layer/src/instance/session.h"

namespace omni::layer {

struct ForceFeedback {
  ForceFeedback(std::shared_ptr<Session> of, const ForceStatus& at_first) : session(std::move(of)), watch(at_first) {}

  // Unique among live records.
  XrForceFeedbackOMNIX1 handle() noexcept { return reinterpret_cast<XrForceFeedbackOMNIX1>(this); }

  const std::shared_ptr<Session> session;

  std::mutex mutex;                          // of what follows; never held during a call to the next layer
  std::vector<LocalConstraint> constraints;  // as set
  std::uint64_t constraint_changes = 0;      // of that list
  protocol::ForceConstraints sent;           // as last sent to the service ...
  std::uint64_t sent_connection = 0;         // ... over this connection
  ForceStatusWatch watch;
};

}  // namespace omni::layer
