// Independent tasks on all processors. Set-up, tools and benchmarks only: starts threads and allocates.
#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace omni::base {

// task(0) ... task(count - 1), in no order, on this thread too; returns when all have ended. A task must not throw.
template <class Task>
void InParallel(std::size_t count, const Task& task) {
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) task(i);
  };
  std::vector<std::jthread> threads;
  for (unsigned k = 1; k < std::thread::hardware_concurrency(); ++k) threads.emplace_back(work);
  work();
}

}  // namespace omni::base
