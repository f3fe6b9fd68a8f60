// Drains the telemetry ring into a CSV file, on a thread of its own: one line per tick, SI units, header names the
// columns.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "service/base/result.h"
#include "service/loop/telemetry.h"

namespace omni::daemon {

class Recorder {
 public:
  // `ring` outlives this.
  static base::Result<std::unique_ptr<Recorder>> Open(const std::string& path, loop::TelemetryRing& ring);
  ~Recorder();  // drains what is left, closes
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  std::uint64_t lines() const noexcept { return lines_.load(std::memory_order_relaxed); }
  // True after a write failed (disk full): nothing more is written, the service goes on.
  bool failed() const noexcept { return failed_.load(std::memory_order_relaxed); }

 private:
  Recorder(std::FILE* file, std::string path, loop::TelemetryRing& ring);
  void Run();
  void Drain();

  std::FILE* file_;
  const std::string path_;
  loop::TelemetryRing& ring_;
  std::atomic<std::uint64_t> lines_{0};
  std::atomic<bool> failed_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace omni::daemon
