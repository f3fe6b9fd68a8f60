// Aims that come over the hand's socket lead the simulated hand.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "service/ipc/listener.h"
#include "service/sim/hand/hand_guide.h"

namespace omni::twin {

class SocketGuide final : public sim::HandGuide {
 public:
  explicit SocketGuide(std::unique_ptr<ipc::HandListener> listener) : listener_(std::move(listener)) {}

  bool Poll(sim::HandAim& aim) noexcept override {
    const std::optional<protocol::HandAim> newest = listener_->Poll();
    if (!newest) return false;
    const auto &p = newest->tip_base_m, &u = newest->axis_base;
    const double length = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    aim = {{p[0], p[1], p[2]}, {u[0] / length, u[1] / length, u[2] / length}, newest->present == 1};
    return true;
  }

 private:
  std::unique_ptr<ipc::HandListener> listener_;
};

}  // namespace omni::twin
