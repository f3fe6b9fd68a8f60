// Speed of a fan from the edges of its tachometer output (open collector, commonly two pulses per turn).
//
// Capture policy:
//   bool NextEdge(std::uint32_t& t_us) noexcept;   the oldest captured falling edge not yet returned
//   std::uint32_t Now_us() noexcept;               the capture's clock; wraps
#pragma once

#include <cstdint>

namespace omni::drivers {

struct FanTachSettings {
  std::uint32_t rpm_max = 12000;     // an edge that implies more is a disturbance
  std::uint32_t stand_us = 500'000;  // no edge for so long: the fan is standing
};

template <class Capture, int kPulsesPerTurn = 2>
class FanTach {
 public:
  explicit FanTach(Capture& capture, const FanTachSettings& settings = FanTachSettings()) noexcept
      : capture_(capture), settings_(settings), last_us_(capture.Now_us()) {}

  // At least once per stand_us, otherwise as often as desired; reads at most kEdgesPerUpdate edges.
  void Update() noexcept {
    std::uint32_t t_us = 0;
    for (int i = 0; i < kEdgesPerUpdate && capture_.NextEdge(t_us); ++i) Take(t_us);
    since_us_ = capture_.Now_us() - last_us_;
    // Later the clock wraps and `since_us_` with it, so standing is kept until edges come.
    if (since_us_ > settings_.stand_us) {
      edges_ = 0;
      standing_ = true;
    }
  }

  // Mean over the last turn, 0 until there was one. Without edges it falls with the time since the last one, so that a
  // stopping fan is never reported faster than it can be.
  std::uint32_t rpm() const noexcept {
    if (edges_ <= kPulsesPerTurn) return 0;
    const std::uint32_t turn_us = last_us_ - times_us_[(edges_at_ + 1) % (kPulsesPerTurn + 1)];
    const std::uint32_t waiting_us = since_us_ * kPulsesPerTurn;
    return kMinute_us / (waiting_us > turn_us ? waiting_us : turn_us);
  }

  bool standing() const noexcept { return standing_; }
  std::uint32_t disturbances() const noexcept { return disturbances_; }

  static constexpr int kEdgesPerUpdate = 16;

 private:
  static constexpr std::uint32_t kMinute_us = 60'000'000;
  static_assert(kPulsesPerTurn >= 1, "pulses a turn");

  void Take(std::uint32_t t_us) noexcept {
    const std::uint32_t period_min_us = kMinute_us / (settings_.rpm_max * kPulsesPerTurn);
    if (edges_ > 0 && t_us - last_us_ < period_min_us) {
      ++disturbances_;
      return;
    }
    edges_at_ = (edges_at_ + 1) % (kPulsesPerTurn + 1);
    times_us_[edges_at_] = t_us;
    last_us_ = t_us;
    if (edges_ <= kPulsesPerTurn) ++edges_;
    if (edges_ > kPulsesPerTurn) standing_ = false;
  }

  Capture& capture_;
  FanTachSettings settings_;
  std::uint32_t times_us_[kPulsesPerTurn + 1] = {};
  std::uint32_t last_us_;
  std::uint32_t since_us_ = 0;
  std::uint32_t disturbances_ = 0;
  int edges_ = 0, edges_at_ = 0;
  bool standing_ = true;
};

}  // namespace omni::drivers
