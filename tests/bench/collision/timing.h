// Times every tick of a batch of 1000; batches in which the system took the processor away do not count.
#pragma once

#include <sys/resource.h>
#include <x86intrin.h>

#include <chrono>
#include <span>
#include <thread>
#include <vector>

#include "service/tools/common/row_table.h"
#include "tests/bench/collision/engine.h"

namespace omni::collision {

inline constexpr std::size_t kBatch = 1000;

inline double TicksPerMicrosecond() {
  static const double kRate = [] {
    const auto start = std::chrono::steady_clock::now();
    const std::uint64_t begin = __rdtsc();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const std::uint64_t end = __rdtsc();
    const auto elapsed = std::chrono::steady_clock::now() - start;
    return static_cast<double>(end - begin) / std::chrono::duration<double, std::micro>(elapsed).count();
  }();
  return kRate;
}

struct Times {
  std::vector<double> median_us, p99_us, p999_us;  // one per batch
};

// Runs one batch; its times count if it was undisturbed. Distances go to `distances` (a batch of them).
inline bool RunBatch(Engine& engine, std::span<const Vec3> tips, std::span<double> distances, Times& times) {
  const auto switches = [] {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nivcsw;
  };
  std::vector<double> us(tips.size());
  const long before = switches();
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const std::uint64_t begin = __rdtsc();
    distances[i] = engine.Tick(tips[i]);
    us[i] = static_cast<double>(__rdtsc() - begin);
  }
  if (switches() != before) return false;
  for (double& x : us) x /= TicksPerMicrosecond();
  times.median_us.push_back(tools::Quantile(us, 0.5));
  times.p99_us.push_back(tools::Quantile(us, 0.99));
  times.p999_us.push_back(tools::Quantile(us, 0.999));
  return true;
}

}  // namespace omni::collision
