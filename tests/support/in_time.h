// Waits for what other threads or processes do.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "service/base/sanitized.h"

namespace omni::test {

// True as soon as `holds` is; false after a time that only a broken program needs: ten times `limit` for one that is
// instrumented.
inline bool InTime(const std::function<bool()>& holds, std::chrono::seconds limit = std::chrono::seconds(30)) {
  const auto end = std::chrono::steady_clock::now() + (base::kSanitized ? 10 : 1) * limit;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace omni::test
