// omnid's log. Whatever this process, its libraries and its children write to standard output or standard error goes
// into a pipe and from there, on a thread, to the standard error that omnid was started with, limited by LineLimit.
// Writers never wait for the reader of the log: lines that find the pipe full are lost, counted and reported.
#pragma once

#include <memory>
#include <string>
#include <thread>

namespace omni::daemon {

class LogQueue {
 public:
  static constexpr int kEndWait_ms = 200;

  // Redirects descriptors 1 and 2 and becomes spdlog's default logger; one at a time. `level` is one of spdlog's words.
  // Throws std::system_error.
  explicit LogQueue(const std::string& level);
  // Waits at most kEndWait_ms for what is queued, then gives the descriptors back.
  ~LogQueue();
  LogQueue(const LogQueue&) = delete;
  LogQueue& operator=(const LogQueue&) = delete;

  // Waits at most `most_ms` until all lines are written. Any thread, and signal handlers.
  static void Flush(int most_ms) noexcept;

  struct State;

 private:
  std::shared_ptr<State> state_;
  int output_before_ = -1;  // descriptor 1
  std::thread thread_;
};

}  // namespace omni::daemon
