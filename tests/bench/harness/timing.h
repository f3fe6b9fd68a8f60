// Times of short calls on a shared machine: batches of calls during which the kernel took the thread off its core are
// discarded. Median over batches; 99th percentile per 1000 calls, median over thousands. Every batch starts with a few
// calls that do not count, so that earlier work does not matter; the clock's own cost is subtracted.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "service/tools/common/row_table.h"

namespace omni::bench {

inline long InvoluntarySwitches() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

// Of one reading of the clock.
inline double ClockCost_us() {
  using Clock = std::chrono::steady_clock;
  constexpr int kReadings = 1000;
  static const double kCost_us = [] {
    std::vector<double> cost_us;
    for (int round = 0; round < 21; ++round) {
      const Clock::time_point begin = Clock::now();
      Clock::time_point end = begin;
      for (int i = 0; i < kReadings; ++i) end = Clock::now();
      cost_us.push_back(std::chrono::duration<double, std::micro>(end - begin).count() / kReadings);
    }
    return tools::Quantile(cost_us, 0.5);
  }();
  return kCost_us;
}

class CallTimer {
 public:
  static constexpr double kBatch_us = 1000;  // short against the scheduler's slice
  static constexpr std::size_t kPerPercentile = 1000;
  static constexpr int kWarmUp = 16;

  // Calls call(0), call(1), ... for about kBatch_us, after kWarmUp calls that are not timed.
  template <class Call>
  void Batch(Call&& call) {
    using Clock = std::chrono::steady_clock;
    batch_us_.clear();
    const double clock_us = ClockCost_us();
    for (int i = 0; i < kWarmUp; ++i) call(next_++);
    const long switches = InvoluntarySwitches();
    const Clock::time_point begin = Clock::now();
    Clock::time_point last = begin;
    double total_us = 0;
    while (total_us < kBatch_us) {
      call(next_++);
      const Clock::time_point now = Clock::now();
      batch_us_.push_back(std::max(0.0, std::chrono::duration<double, std::micro>(now - last).count() - clock_us));
      total_us = std::chrono::duration<double, std::micro>(now - begin).count();
      last = now;
    }
    if (InvoluntarySwitches() != switches) {
      ++interrupted_;
      return;
    }
    means_us_.push_back(std::max(0.0, total_us / static_cast<double>(batch_us_.size()) - clock_us));
    calls_us_.insert(calls_us_.end(), batch_us_.begin(), batch_us_.end());
    if (calls_us_.size() < kPerPercentile) return;
    p99s_us_.push_back(tools::Quantile(calls_us_, 0.99));
    calls_us_.clear();
  }

  std::size_t calls() const noexcept { return next_; }
  std::size_t batches() const noexcept { return means_us_.size(); }
  std::size_t interrupted() const noexcept { return interrupted_; }
  double us_median() const { return tools::Quantile(means_us_, 0.5); }
  double us_p99() const { return p99s_us_.empty() ? tools::Quantile(calls_us_, 0.99) : tools::Quantile(p99s_us_, 0.5); }

 private:
  std::vector<double> batch_us_, means_us_, calls_us_, p99s_us_;
  std::size_t next_ = 0;
  std::size_t interrupted_ = 0;
};

}  // namespace omni::bench
