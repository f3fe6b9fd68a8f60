// Waits for SIGINT, SIGTERM and SIGHUP on a thread of its own, so that they end omnid in time whatever main and the
// other threads are doing. The first one asks main to end. When main has not ended kPatience_ns later, or a second one
// comes, the coils are taken to zero and the process exits at once: a scene that was being built, or a disk or base
// that does not respond, is abandoned. While a recording is open a second one changes nothing: terminals and
// supervisors signal a whole group, and a program in it passes the signal on.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "service/base/unique_fd.h"

namespace omni::daemon {

class EndWatch {
 public:
  static constexpr std::int64_t kPatience_ns = 750'000'000;
  static constexpr int kLogWait_ms = 100;  // for the last lines, when the process ends at once

  // Blocks these signals for the calling thread and for those that it starts later. Throws std::system_error.
  EndWatch();
  ~EndWatch();  // main has ended by itself
  EndWatch(const EndWatch&) = delete;
  EndWatch& operator=(const EndWatch&) = delete;

  // Waits at most `most_ms`. True: the service is to end.
  bool Wait(int most_ms) const;

  // Whether a recording is incomplete until main closes it. Then an immediate exit has status 1, else 0.
  void SetRecording(bool recording) { recording_.store(recording); }

  // While it lives, `zero` is called to take the coils to zero; it must return soon, on any thread.
  class CoilsToZero {
   public:
    CoilsToZero(EndWatch& watch, std::function<void()> zero) : watch_(watch) { watch_.SetZero(std::move(zero)); }
    ~CoilsToZero() { watch_.SetZero({}); }
    CoilsToZero(const CoilsToZero&) = delete;
    CoilsToZero& operator=(const CoilsToZero&) = delete;

   private:
    EndWatch& watch_;
  };

 private:
  void Run();
  void SetZero(std::function<void()> zero);
  [[noreturn]] void EndAtOnce(const char* why);

  base::UniqueFd signals_, asked_, stop_;
  std::atomic<bool> recording_{false};
  std::mutex zero_mutex_;
  std::function<void()> zero_;
  std::thread thread_;
};

}  // namespace omni::daemon
