// A line of LOG, formatted without printf.
#pragma once

#include "firmware/wire/messages.h"

namespace omni::firmware {

class LogLine {
 public:
  explicit LogLine(wire::LogLevel level) noexcept { log_.level = level; }

  LogLine& AddText(const char* text) noexcept {
    for (; *text != '\0'; ++text) Put(*text);
    return *this;
  }
  LogLine& AddNumber(std::uint32_t value) noexcept {
    char digits[10];
    int count = 0;
    do {
      digits[count++] = static_cast<char>('0' + value % 10);
      value /= 10;
    } while (value > 0);
    while (count > 0) Put(digits[--count]);
    return *this;
  }

  const wire::Log& log() const noexcept { return log_; }

 private:
  void Put(char character) noexcept {  // truncates a long line
    if (log_.size < wire::kLogTextMax) log_.text[log_.size++] = character;
  }

  wire::Log log_;
};

// A limited burst of lines, then a limited rate per second: a loose contact must not flood the link.
class LogRate {
 public:
  bool Allows(std::uint64_t now_us) noexcept {
    if (tokens_ < kBurst && now_us - filled_us_ >= kPeriod_us) {
      const std::uint64_t due = (now_us - filled_us_) / kPeriod_us;
      tokens_ = due >= kBurst ? kBurst : static_cast<int>(due) + tokens_;
      if (tokens_ > kBurst) tokens_ = kBurst;
      filled_us_ = now_us;
    }
    if (tokens_ == kBurst) filled_us_ = now_us;
    if (tokens_ == 0) return false;
    --tokens_;
    return true;
  }

 private:
  static constexpr int kBurst = 10;
  static constexpr std::uint64_t kPeriod_us = 200'000;

  int tokens_ = kBurst;
  std::uint64_t filled_us_ = 0;
};

}  // namespace omni::firmware
