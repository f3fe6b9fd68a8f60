// The log of omnid: whether or not it is read does not affect the service, and clients cannot fill the disk through it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "service/base/clock.h"
#include "service/daemon/log_queue.h"
#include "service/tools/common/service_link.h"
#include "tests/support/process/service_end.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_log {

constexpr const char* kStranger = "log_test";  // no scene: each of its sessions logs a line

// Waits at most 2 s for the service to accept it.
bool Send(TestApplication& app, protocol::SessionState state) {
  for (int tries = 0; tries < 2000; ++tries) {
    if (app.connection().SendSession(state)) return true;
    app.connection().Poll(base::MonotonicNow_ns());
    SleepMs(1);
  }
  return false;
}

// Sessions that begin and end, `count` times. How many did.
int Toggle(TestApplication& app, int count) {
  for (int i = 0; i < count; ++i) {
    if (!Send(app, protocol::SessionState::kBegun) || !Send(app, protocol::SessionState::kNone)) return i;
    if (i % 16 == 0) app.connection().Poll(base::MonotonicNow_ns());  // reads the service's messages
  }
  return count;
}

bool AnswersStatus(const ServiceProcess& service) { return tools::FetchStatus(service.socket_path()).ok(); }

std::string Content(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// A service with an unread log and a focused application.
struct UnreadLog {
  UnreadLog() : pipe(service.Path("log"), UnreadPipe::Reader::kSleeps), app(service.socket_path(), kStranger) {
    service.Start({}, pipe.path());
    EXPECT_TRUE(app.Focus()) << app.connection().last_error();
    pipe.Fill();
  }
  ServiceProcess service;
  UnreadPipe pipe;
  TestApplication app;
};

void ExpectGoodEnd(ServiceProcess& service, const char* what) {
  const ServiceEnd end = EndAndWait(service, what);
  EXPECT_EQ(end.status, 0);
  EXPECT_LT(end.ms, kEndsWithin_ms);
}

TEST(ProcessLog, UnreadLogPipeBlocksNeitherControlNorExit) {
  UnreadLog log;
  EXPECT_EQ(Toggle(log.app, 2000), 2000);
  EXPECT_TRUE(AnswersStatus(log.service));
  ExpectGoodEnd(log.service, "its log is a full pipe");
}

TEST(ProcessLog, ReportsDroppedLinesOnceReadAgain) {
  UnreadLog log;
  ASSERT_EQ(Toggle(log.app, 2000), 2000);  // more than the service's own pipe holds
  ASSERT_TRUE(AnswersStatus(log.service));
  const std::string text = log.pipe.Read(500);
  EXPECT_NE(text.find("lines of this log are missing"), std::string::npos) << text.substr(text.find_first_not_of('.'));
  EXPECT_EQ(log.service.Stop(), 0);
}

std::size_t LinesWith(const std::string& text, const std::string& words) {
  std::size_t lines = 0;
  for (std::size_t at = 0; (at = text.find(words, at)) != std::string::npos; at += words.size()) ++lines;
  return lines;
}

struct ToggleLog {
  std::size_t lines;
  double seconds;
};

// What so many toggles cost.
ToggleLog LogOf(int toggles) {
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  ServiceProcess service;
  service.Start({}, service.Path("log"));
  {
    TestApplication app(service.socket_path(), kStranger);
    EXPECT_TRUE(app.Focus()) << app.connection().last_error();
    EXPECT_EQ(Toggle(app, toggles), toggles);
    EXPECT_TRUE(AnswersStatus(service)) << "all of them have been heard";
  }
  EXPECT_EQ(service.Stop(), 0);
  const std::string text = Content(service.Path("log"));
  std::printf("[ figure   ] %d toggles: %zu bytes of log\n", toggles, text.size());
  EXPECT_NE(text.find("no scene for application"), std::string::npos);
  // A starved computer may cut the end short, and with it the report of what was held back.
  if (toggles > 1000 && text.find("before everything has shut down") == std::string::npos) {
    EXPECT_NE(text.find("more of these in the last"), std::string::npos) << text.substr(0, 4000);
  }
  return {LinesWith(text, "no scene for application"), 1e-9 * static_cast<double>(base::MonotonicNow_ns() - begin_ns)};
}

TEST(ProcessLog, RepeatedSessionChangesAreRateLimited) {
  for (const int toggles : {200, 10'000}) {
    const ToggleLog log = LogOf(toggles);
    const double most =
        daemon::LineLimit::kBurst + 2 + log.seconds / (1e-9 * static_cast<double>(daemon::LineLimit::kPeriod_ns));
    EXPECT_LE(static_cast<double>(log.lines), most) << toggles << " toggles in " << log.seconds << " s";
  }
}

TEST(ProcessLog, ErrorsBeforeTheServiceRunsAreWritten) {
  ServiceProcess service;
  service.StartProgram(
      {std::string(OMNI_BINARY_DIR) + "/bin/omnid", "--device", "twin", "--socket", "/proc/no/omnid.sock"},
      service.Path("log"));
  EXPECT_EQ(service.Wait(), 1);
  EXPECT_NE(Content(service.Path("log")).find("/proc/no"), std::string::npos);
}

// libusb writes its own messages, from the thread that looks for a base.
TEST(ProcessLog, LibraryOutputToFullPipeDoesNotBlock) {
  ServiceProcess service;
  const UnreadPipe log(service.Path("log"), UnreadPipe::Reader::kSleeps);
  log.Fill();  // before anything is written
  service.StartProgram({std::string(OMNI_BINARY_DIR) + "/bin/omnid", "--device", "usb"}, log.path(),
                       {"LIBUSB_DEBUG=4"});
  EXPECT_TRUE(WaitUntilServing(service));
  ExpectGoodEnd(service, "libusb writes into a full pipe");
}

// The simulation is a process of its own that writes to the same log.
TEST(ProcessLog, IncludesTwinOutput) {
  ServiceProcess service;
  const std::string open_folder = service.Path("open");
  std::filesystem::create_directory(open_folder);
  std::filesystem::permissions(open_folder, std::filesystem::perms(0755));
  service.StartProgram(
      {std::string(OMNI_BINARY_DIR) + "/bin/omnid", "--device", "twin", "--twin-hand", open_folder + "/hand.sock"},
      service.Path("log"));
  EXPECT_TRUE(WaitUntilServing(service));
  EXPECT_EQ(service.Stop(), 0);
  EXPECT_NE(Content(service.Path("log")).find(open_folder), std::string::npos);
}

}  // namespace test_process_log
}  // namespace omni::test
