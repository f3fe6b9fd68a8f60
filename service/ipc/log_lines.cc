#include "service/ipc/log_lines.h"

#include <cstdio>
#include <utility>

namespace omni::ipc {
namespace {

constexpr std::int64_t kRepeatAfter_ns = 60'000'000'000;
constexpr std::int64_t kWindow_ns = 1'000'000'000;
constexpr int kMaxLinesPerWindow = 20;  // further ones are dropped

}  // namespace

LogLines::LogLines(std::function<void(const std::string&)> sink) : sink_(std::move(sink)) {
  if (!sink_) sink_ = [](const std::string& line) { std::fprintf(stderr, "omnid: %s\n", line.c_str()); };
}

void LogLines::Write(const std::string& line, std::int64_t now_ns) {
  if (line == last_line_ && now_ns - last_ns_ < kRepeatAfter_ns) return;
  if (now_ns - window_start_ns_ >= kWindow_ns) {
    window_start_ns_ = now_ns;
    lines_in_window_ = 0;
  }
  if (++lines_in_window_ > kMaxLinesPerWindow) return;
  last_line_ = line;
  last_ns_ = now_ns;
  sink_(line);
}

}  // namespace omni::ipc
