// omnid's log. Whatever this process, its libraries and its children write to standard output or standard error goes
// into a pipe and from there, on a thread, to the standard error that omnid was started with, limited by LineLimit.
// Writers never wait for the reader of the log: lines that find the pipe full are lost, counted and reported.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace omni::daemon {

// Keeps a repeating message from filling the disk: of each kind a burst is written, after that one line every few
// seconds, with the number of lines left out. Two lines are of one kind if they differ only in digits and in text in
// quotation marks.
class LineLimit {
 public:
  static constexpr int kBurst = 20;
  static constexpr std::int64_t kPeriod_ns = 10'000'000'000;
  static constexpr std::size_t kMaxKinds = 64;  // at once; when full, further kinds share one limit

  LineLimit();

  // Appends `line` (without its end) to `out`, or holds it back.
  void Add(std::string_view line, std::int64_t now_ns, std::string& out);
  // Appends what was held back and may be written now: the newest line of each kind, and how many more there were.
  void AppendDueLines(std::int64_t now_ns, std::string& out);
  // The same for everything held back, due or not: the log ends.
  void ReportAll(std::int64_t now_ns, std::string& out);
  bool holds_back() const;

 private:
  struct Kind {
    std::string pattern;
    int tokens = kBurst;
    std::int64_t filled_ns = 0;
    std::string newest;  // of the lines that are held back
    std::uint64_t held_back = 0;
    std::int64_t since_ns = 0;  // of the first of them

    bool idle() const { return tokens == kBurst && held_back == 0; }
  };
  Kind& KindOf(std::string_view line, std::int64_t now_ns);
  static void Fill(Kind& kind, std::int64_t now_ns);
  static void ReportOne(Kind& kind, std::int64_t now_ns, std::string& out);

  std::vector<Kind> kinds_;  // the first one is shared by kinds beyond kMaxKinds
};

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
