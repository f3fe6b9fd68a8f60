// When no pose explains what the sensors read: would one, were two of them exchanged? Off the tick, a few of the 28
// pairs at a time.
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

namespace omni::daemon {

class SwapSearch {
 public:
  static constexpr std::size_t kScans = 6;                // that are tried
  static constexpr std::int64_t kApart_ns = 250'000'000;  // from one to the next
  static constexpr int kPairsAtOnce = 4;
  static constexpr int kFits = 5;    // of the scans, by the pair that is exchanged ...
  static constexpr int kOthers = 2;  // ... and at most by any other, or by none

  explicit SwapSearch(const base::Calibration& calibration);

  // A scan with a magnet near that no pose explains; kept while some are wanted.
  void Keep(const base::HallScan& scan);
  // Now and then: works on. True: it is through, and begins anew with other scans; `found` is what came out.
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

}  // namespace omni::daemon
