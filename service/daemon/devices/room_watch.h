// What is wrong with sensors or with the room, from samples of the loop. On the thread that keeps the device, never in
// the tick. docs/howto/calibrate.md, What is said of the room
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "service/base/calibration.h"
#include "service/daemon/devices/field_watch.h"
#include "service/daemon/devices/room_finding.h"
#include "service/daemon/devices/sensor_watch.h"
#include "service/daemon/devices/swap_search.h"
#include "service/daemon/devices/verdict.h"
#include "service/loop/telemetry.h"

namespace omni::daemon {

class RoomWatch {
 public:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000;
  static constexpr int kSamplesMin = 4;  // of a second that says something

  // calibration: in use; null: the base works as drawn, whose room is not known.
  explicit RoomWatch(const base::Calibration* calibration);

  // About ten times a second, the newest sample; one that was seen before is none. True: the findings have changed.
  bool Add(const loop::RoomSample& sample);
  const std::vector<RoomFinding>& findings() const noexcept { return findings_; }
  // They say why no pose explains the readings; the calibration is not to blame.
  bool explains_misfit() const noexcept;

 private:
  void EndSecond();
  bool IsExplained() const noexcept;  // by the sensors themselves
  std::vector<RoomFinding> Report() const;

  SensorWatch sensors_;
  std::optional<FieldWatch> field_;
  std::optional<SwapSearch> swap_;
  Verdict is_contradicted_{2};
  std::int64_t second_ns_ = 0, last_ns_ = 0;       // stamps: the second's begin; the last sample
  int samples_ = 0, near_ = 0, contradicted_ = 0;  // of this second
  std::vector<RoomFinding> findings_;
};

}  // namespace omni::daemon
