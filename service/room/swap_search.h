// When no pose explains the readings: finds out whether one would if two sensors were exchanged. Off the tick, a few of
// the 28 pairs at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "service/base/calibration.h"
#include "service/base/hall_scan.h"
#include "service/base/limits.h"
#include "service/tracker/solve/static_solve.h"

namespace omni::room {

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
