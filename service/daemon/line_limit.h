// Keeps a repeating message from filling the disk: of each kind a burst is written, after that one line every few
// seconds, with the number of lines left out. Two lines are of one kind if they differ only in digits and in text in
// quotation marks.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace omni::daemon {

class LineLimit {
 public:
  static constexpr int kBurst = 20;
  static constexpr std::int64_t kPeriod_ns = 10'000'000'000;
  static constexpr std::size_t kMaxKinds = 64;  // at once; when full, further kinds share one limit

  LineLimit();

  // Appends `line` (without its end) to `out`, or holds it back.
  void Add(std::string_view line, std::int64_t now_ns, std::string& out);
  // Appends what was held back and may be written now: the newest line of each kind, and how many more there were.
  void Report(std::int64_t now_ns, std::string& out);
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

}  // namespace omni::daemon
