// What is wrong with sensors or with the room, from samples of the loop. On the thread that keeps the device, never in
// the tick. docs/howto/calibrate.md, Problems with sensors and the room
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/room/field_watch.h"
#include "service/room/room_finding.h"
#include "service/room/sensor_watch.h"
#include "service/room/verdict.h"
#include "service/tracker/room_sample.h"

namespace omni::room {

// Whether the pen in use has another magnet than the calibrated one.
class PenWatch {
 public:
  static constexpr double kOther = 0.025;    // of the moment; a magnet that is 20 K warmer has lost as much
  static constexpr double kChanged = 0.015;  // until another number is reported

  void Add(const base::ToolState& tool) noexcept;
  void EndSecond() noexcept;
  void Report(std::vector<RoomFinding>& findings) const;

 private:
  int tracked_ = 0, other_ = 0;  // samples of this second
  double sum_ = 0;               // of the moments of the latter, over the calibrated one's ...
  double sigma_sum_ = 0;         // ... and of their standard deviations
  Verdict is_other_{2};
  double moment_scale_ = 1, moment_sigma_ = 0;  // as reported
};

class RoomWatch {
 public:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000;
  static constexpr int kSamplesMin = 4;  // of a second that counts

  // calibration: in use; null: uncalibrated, the room is not known.
  explicit RoomWatch(const base::Calibration* calibration);

  // The newest sample, about ten times a second; a repeated one is ignored. True: the findings have changed.
  bool Add(const tracker::RoomSample& sample);
  const std::vector<RoomFinding>& findings() const noexcept { return findings_; }
  // The uniform field about the base, base frame, and the second it is of; empty: not known.
  const std::optional<RoomField>& field() const noexcept { return room_field_; }
  // The findings say why no pose explains the readings; the calibration is not to blame.
  bool explains_misfit() const noexcept;

 private:
  void EndSecond();
  bool IsExplained() const noexcept;  // by the sensors themselves
  std::vector<RoomFinding> Report() const;

  SensorWatch sensors_;
  std::optional<FieldWatch> field_;
  PenWatch pen_;
  std::optional<SwapSearch> swap_;
  Verdict is_contradicted_{2};
  std::int64_t second_ns_ = 0, last_ns_ = 0;       // stamps: the second's begin; the last sample
  int samples_ = 0, near_ = 0, contradicted_ = 0;  // of this second
  int softened_s_ = 0;                             // seconds for which the last swing is still reported
  bool softened_ = false;                          // in this second
  std::vector<RoomFinding> findings_;
  std::optional<RoomField> room_field_;
};

}  // namespace omni::room
