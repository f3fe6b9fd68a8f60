// How often a repeated message is written.
#include <gtest/gtest.h>

#include <algorithm>

#include "service/daemon/log_queue.h"

namespace omni::daemon {
namespace test_daemon_line_limit {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::size_t Lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(LineLimit, WritesABurstThenOneLinePerPeriodWithOmittedCount) {
  LineLimit limit;
  std::string text;
  for (int i = 0; i < 1000; ++i) limit.Add("client " + std::to_string(i) + " is gone", kSecond_ns, text);
  EXPECT_EQ(Lines(text), std::size_t{LineLimit::kBurst});
  EXPECT_TRUE(limit.holds_back());
  text.clear();
  limit.AppendDueLines(2 * kSecond_ns, text);
  EXPECT_EQ(text, "") << "not due yet";
  limit.AppendDueLines(kSecond_ns + LineLimit::kPeriod_ns, text);
  EXPECT_EQ(text, "client 999 is gone (979 more of these in the last 10 s)\n");
  EXPECT_FALSE(limit.holds_back());
}

TEST(LineLimit, NextWrittenLineGivesOmittedCount) {
  LineLimit limit;
  std::string text;
  for (int i = 0; i < LineLimit::kBurst + 3; ++i) limit.Add("a line", 0, text);
  text.clear();
  limit.Add("a line", LineLimit::kPeriod_ns, text);
  EXPECT_EQ(text, "a line (3 more of these in the last 10 s)\n");
}

TEST(LineLimit, SingleHeldLineIsWrittenUnchanged) {
  LineLimit limit;
  std::string text;
  for (int i = 0; i < LineLimit::kBurst + 1; ++i) limit.Add("line " + std::to_string(i), 0, text);
  text.clear();
  limit.ReportAll(0, text);
  EXPECT_EQ(text, "line 20\n");
}

TEST(LineLimit, EachKindHasItsOwnLimit) {
  LineLimit limit;
  std::string text;
  for (int i = 0; i < 100; ++i) limit.Add("client 1: application \"a" + std::string(i, 'b') + "\"", 0, text);
  EXPECT_EQ(Lines(text), std::size_t{LineLimit::kBurst}) << "a name in quotation marks makes no kind of its own";
  limit.Add("device: lost", 0, text);
  EXPECT_EQ(Lines(text), std::size_t{LineLimit::kBurst} + 1);
}

TEST(LineLimit, KindsBeyondTheMaximumShareOneLimit) {
  LineLimit limit;
  std::string text;
  for (std::size_t i = 0; i < 1000; ++i) limit.Add(std::string(1 + i % 150, 'x') + std::string(i / 150, 'y'), 0, text);
  EXPECT_EQ(Lines(text), LineLimit::kMaxKinds + LineLimit::kBurst);
}

TEST(LineLimit, IdleKindsAreReplacedByNewOnes) {
  LineLimit limit;
  std::string text;
  std::int64_t now_ns = 0;
  for (std::size_t i = 0; i < 10 * LineLimit::kMaxKinds; ++i) {
    now_ns += LineLimit::kPeriod_ns;
    limit.Add(std::string(1 + i % 150, 'x') + std::string(i / 150, 'y'), now_ns, text);
  }
  EXPECT_EQ(Lines(text), 10 * LineLimit::kMaxKinds) << "lines that come now and then are all written";
}

TEST(LineLimit, FloodWritesNoMoreThanBurstPlusOneLinePerPeriod) {
  LineLimit limit;
  std::string text;
  constexpr std::int64_t kFor_s = 600;
  for (std::int64_t i = 0; i < kFor_s * 100; ++i) {
    limit.Add("toggled " + std::to_string(i), i * kSecond_ns / 100, text);
    limit.AppendDueLines(i * kSecond_ns / 100, text);
  }
  EXPECT_LE(Lines(text), LineLimit::kBurst + static_cast<std::size_t>(kFor_s * kSecond_ns / LineLimit::kPeriod_ns));
}

}  // namespace test_daemon_line_limit
}  // namespace omni::daemon
