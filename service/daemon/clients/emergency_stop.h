// The emergency stop: whether it is on, and its latch, a file by which the next omnid knows of it too. The stop never
// waits for the latch. Control thread only.
#pragma once

#include <cstdint>
#include <string>

#include "service/config/files/stop_file.h"
#include "service/daemon/file_writer.h"

namespace omni::daemon {

class EmergencyStop {
 public:
  enum class Latch : std::uint8_t {
    kNone,     // and none is wanted
    kPending,  // is being written or removed
    kKept,     // on the disk: the stop outlives omnid
    kFailed    // could not be written (the stop holds until omnid ends), or removed (the next omnid starts stopped)
  };
  struct State {
    bool on = false;
    std::string by, at;        // who pressed it, and when (ISO 8601, UTC)
    bool from_before = false;  // by the latch that an earlier omnid left
    Latch latch = Latch::kNone;
    std::string file;
    std::string problem;  // of a latch that failed
  };

  static constexpr std::int64_t kCheckEvery_ns = 1'000'000'000;  // that the latch is still there, or can be written now

  // Reads the latch: on if there is one. An empty path: none is kept.
  explicit EmergencyStop(std::string path);

  bool on() const { return state_.on; }
  const State& state() const { return state_; }
  // For people; empty: all is well.
  std::string Problem() const;

  void Press(const std::string& who);
  void Release();
  // Once per period: results of the disk. Returns a line for the log if one is bad or good again.
  std::string Poll(std::int64_t now_ns);

 private:
  void Request();
  void Settle(const base::Status& status);

  State state_;
  FileWriter writer_;
  std::uint64_t requested_ = 0, written_ = 0;
  std::int64_t checked_ns_ = 0;
};

}  // namespace omni::daemon
