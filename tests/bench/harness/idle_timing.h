// Timing on a shared machine: batches in which the system took the processor away are left out.
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <cstdint>
#include <vector>

#include "service/tools/common/row_table.h"

namespace omni::bench {

struct IdleTiming {
  double us_median = 0;  // median over the undisturbed batches of the batch's median ...
  double us_p99 = 0;     // ... and of its 99th percentile
  int quiet_batches = 0;
  int batches = 0;
};

// Calls work(i) for i = 0, 1, ... and times `group` calls at a time (short work drowns in the clock's own 25 ns), until
// there are `quiet_batches` or kPatience_s have passed. `prepare` is called before each group and is not timed.
template <class Work, class Prepare>
IdleTiming TimeWhenIdle(int quiet_batches, int batch_size, int group, Work&& work, Prepare&& prepare) {
  constexpr double kPatience_s = 10;
  using Clock = std::chrono::steady_clock;
  const auto switches = [] {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nivcsw;
  };
  std::vector<double> medians, tails, us(static_cast<std::size_t>(batch_size));
  IdleTiming timing;
  std::uint64_t next = 0;
  const Clock::time_point start = Clock::now();
  while (timing.quiet_batches < quiet_batches &&
         std::chrono::duration<double>(Clock::now() - start).count() < kPatience_s) {
    ++timing.batches;
    const long before = switches();
    for (double& each_us : us) {
      prepare();
      const Clock::time_point begin = Clock::now();
      for (int i = 0; i < group; ++i) work(next++);
      each_us = std::chrono::duration<double, std::micro>(Clock::now() - begin).count() / group;
    }
    if (switches() != before) continue;
    medians.push_back(tools::Quantile(us, 0.5));
    tails.push_back(tools::Quantile(us, 0.99));
    ++timing.quiet_batches;
  }
  timing.us_median = tools::Quantile(medians, 0.5);
  timing.us_p99 = tools::Quantile(tails, 0.5);
  return timing;
}

template <class Work>
IdleTiming TimeWhenIdle(int quiet_batches, int batch_size, int group, Work&& work) {
  return TimeWhenIdle(quiet_batches, batch_size, group, work, [] {});
}

}  // namespace omni::bench
