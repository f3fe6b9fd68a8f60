// Whether the tracker's poses explain the sensors' readings while a magnet is near. They do not with a calibration of
// another base, or of a base that was changed since, or with a second magnet beside the pen.
#pragma once

#include <cstdint>

namespace omni::daemon {

// Turns counts of loop::FitStatistics into a verdict, second by second. Seconds without a pen leave the verdict as it
// is.
class FitWatch {
 public:
  static constexpr std::int64_t kSpan_ns = 1'000'000'000;
  static constexpr std::uint64_t kTicksMin = 20;  // in a span; without a client there are about 62
  static constexpr int kSpans = 3;                // of one kind in a row, for a verdict
  static constexpr double kMisfitAbove = 0.1;     // share of a span's ticks without an explanation
  static constexpr double kFitsBelow = 0.02;      // a calibration that fits has almost none

  // Call now and then. True: the verdict has changed.
  bool Update(std::uint64_t explained, std::uint64_t contradicted, std::int64_t now_ns) noexcept {
    if (begin_ns_ == 0) Begin(explained, contradicted, now_ns);
    if (now_ns - begin_ns_ < kSpan_ns) return false;
    const std::uint64_t with = explained - explained_, without = contradicted - contradicted_;
    Begin(explained, contradicted, now_ns);
    if (with + without < kTicksMin) return false;
    share_ = static_cast<double>(without) / static_cast<double>(with + without);
    const bool other = misfit_ ? share_ < kFitsBelow : share_ > kMisfitAbove;
    spans_ = other ? spans_ + 1 : 0;
    if (spans_ < kSpans) return false;
    misfit_ = !misfit_;
    spans_ = 0;
    return true;
  }
  bool misfit() const noexcept { return misfit_; }
  double share() const noexcept { return share_; }  // without an explanation, of the last span that counted

 private:
  void Begin(std::uint64_t explained, std::uint64_t contradicted, std::int64_t now_ns) noexcept {
    explained_ = explained;
    contradicted_ = contradicted;
    begin_ns_ = now_ns;
  }

  std::uint64_t explained_ = 0, contradicted_ = 0;  // at the span's begin
  std::int64_t begin_ns_ = 0;
  bool misfit_ = false;
  int spans_ = 0;  // that speak against it, in a row
  double share_ = 0;
};

}  // namespace omni::daemon
