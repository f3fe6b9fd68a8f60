// A function in a separate process, in bounded memory: how it ended and the resources it used.
#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <exception>
#include <fstream>

#include "service/base/sanitized.h"

namespace omni::test {

inline constexpr bool kMemoryCounts = !base::kSanitized;  // sanitizers double it, and use terabytes of address space

// Pages of this process: of its address space, and those in memory.
struct PagesOfProcess {
  std::size_t space = 0, resident = 0;
};
inline PagesOfProcess Pages() {
  PagesOfProcess pages;
  std::ifstream("/proc/self/statm") >> pages.space >> pages.resident;
  return pages;
}

struct ChildOutcome {
  int status = -1;  // what the function returned; < 0: minus the signal that ended it
  double cpu_s = 0;
  double memory_MB = 0;  // peak increase since the start of the process
};

// `space_MB`: limit of its additional address space; 0: unlimited.
template <class Body>
ChildOutcome RunInChild(std::size_t space_MB, Body body) {
  const PagesOfProcess before = Pages();
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const pid_t child = fork();
  if (child == 0) {
    if (space_MB > 0) {
      const rlim_t most = before.space * page + (space_MB << 20);
      const rlimit limit{most, most};
      setrlimit(RLIMIT_AS, &limit);
    }
    int status = 99;
    try {
      status = body();
    } catch (const std::exception& problem) {
      std::fprintf(stderr, "in a child: %s\n", problem.what());
    }
    _exit(status);
  }
  int status = 0;
  rusage used{};
  if (child < 0 || wait4(child, &status, 0, &used) != child) return {};
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), seconds(used.ru_utime) + seconds(used.ru_stime),
          static_cast<double>(used.ru_maxrss) / 1024 - static_cast<double>(before.resident * page) / (1 << 20)};
}

}  // namespace omni::test
