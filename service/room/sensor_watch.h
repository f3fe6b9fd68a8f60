// Finds sensors that are silent, repeat themselves or read wrong: from samples of the loop, second by second.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/hall_scan.h"
#include "service/base/limits.h"
#include "service/base/vec.h"
#include "service/room/room_finding.h"
#include "service/room/verdict.h"
#include "service/tracker/room_sample.h"
#include "service/tracker/solve/static_solve.h"

namespace omni::room {

class SensorWatch {
 public:
  // A sensor is blamed when it was wrong while the pen was in kPlaces places, kPlace_m apart: a magnet beside it does
  // not explain all of them.
  static constexpr std::size_t kPlaces = 3;
  static constexpr double kPlace_m = 0.02;
  static constexpr int kSensorsMin = 4;  // fewer leave too few readings for a pose

  void Add(const tracker::RoomSample& sample);
  void EndSecond();
  // magnet_near: already reported; a sensor that may only be near the magnet is not reported as well.
  void Report(bool magnet_near, std::vector<RoomFinding>& findings) const;

  // Bit i: sensor i cannot be used.
  std::uint32_t useless() const noexcept;
  // No pose can be expected, whatever the calibration.
  bool too_few() const noexcept;

 private:
  struct Sensor {
    int silent = 0, repeats = 0, wrong = 0;  // samples of this second
    base::Vec3 last_T;
    std::vector<base::Vec3> places_base_m;  // of the pen, where it was wrong
    Verdict is_silent{2}, is_stuck{2}, is_wrong{2};
  };
  void AddPlace(const base::ToolState& tool, Sensor& sensor) const;

  std::array<Sensor, base::kSensorCount> sensors_{};
  int samples_ = 0, tracked_ = 0, frozen_ = 0;  // of this second
  Verdict is_frozen_{2};
};

// When no pose explains the readings: finds out whether one would if two sensors were exchanged. Off the tick, a few of
// the 28 pairs at a time.
class SwapSearch {
 public:
  static constexpr std::size_t kScans = 6;                // that are tried
  static constexpr std::int64_t kApart_ns = 250'000'000;  // from one to the next
  static constexpr int kPairsAtOnce = 4;
  static constexpr int kFits = 5;    // scans that the exchanged pair fits at least
  static constexpr int kOthers = 2;  // scans that any other, or no exchange, fits at most

  explicit SwapSearch(const base::Calibration& calibration);

  // A scan with a magnet near that no pose explains; kept until there are kScans.
  void Keep(const base::HallScan& scan);
  // Call now and then: continues. True: finished, `found` is the result, and the search restarts with other scans.
  bool Step();
  const std::optional<std::pair<int, int>>& found() const noexcept { return found_; }
  void Forget();

 private:
  // -1, -1: none is exchanged.
  int Fits(int a, int b) const;

  std::optional<tracker::StaticSolver> solver_;
  std::vector<base::HallScan> scans_;
  std::vector<int> fits_;  // by pair, after that of none
  std::optional<std::pair<int, int>> found_;
};

}  // namespace omni::room
