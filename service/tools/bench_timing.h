// Times of short calls on a machine that is not ours alone: batches of calls during which the kernel took the thread
// off its core are thrown away. Median over batches; 99th percentile per 1000 calls, median over thousands.
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <cstddef>
#include <vector>

#include "service/tools/statistics.h"

namespace omni::tools {

inline long InvoluntarySwitches() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

class CallTimer {
 public:
  static constexpr double kBatch_us = 1000;  // short against the scheduler's slice
  static constexpr std::size_t kPerPercentile = 1000;

  // Calls call(0), call(1), ... for about kBatch_us. The stamps between calls are counted as part of the calls.
  template <class Call>
  void Batch(Call&& call) {
    using Clock = std::chrono::steady_clock;
    batch_us_.clear();
    const long switches = InvoluntarySwitches();
    const Clock::time_point begin = Clock::now();
    Clock::time_point last = begin;
    double total_us = 0;
    while (total_us < kBatch_us) {
      call(next_++);
      const Clock::time_point now = Clock::now();
      batch_us_.push_back(std::chrono::duration<double, std::micro>(now - last).count());
      total_us = std::chrono::duration<double, std::micro>(now - begin).count();
      last = now;
    }
    if (InvoluntarySwitches() != switches) {
      ++interrupted_;
      return;
    }
    means_us_.push_back(total_us / static_cast<double>(batch_us_.size()));
    calls_us_.insert(calls_us_.end(), batch_us_.begin(), batch_us_.end());
    if (calls_us_.size() < kPerPercentile) return;
    p99s_us_.push_back(Quantile(calls_us_, 0.99));
    calls_us_.clear();
  }

  std::size_t batches() const noexcept { return means_us_.size(); }
  std::size_t interrupted() const noexcept { return interrupted_; }
  double us_median() const { return Quantile(means_us_, 0.5); }
  double us_p99() const { return p99s_us_.empty() ? Quantile(calls_us_, 0.99) : Quantile(p99s_us_, 0.5); }

 private:
  std::vector<double> batch_us_, means_us_, calls_us_, p99s_us_;
  std::size_t next_ = 0;
  std::size_t interrupted_ = 0;
};

}  // namespace omni::tools
