// The emergency stop through crashes: what omnid does when it starts again, and what people read about it.
#include <gtest/gtest.h>

#include <filesystem>

#include <nlohmann/json.hpp>

#include "service/tools/common/service_link.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/service_end.h"

namespace omni::test {
namespace test_process_stop {

namespace fs = std::filesystem;

constexpr double kPushing_N = 0.2;
constexpr int kLong_ms = 3000;

Outcome Stop(const ServiceProcess& service, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"stop", "--socket", service.socket_path()});
  return RunOmni(more);
}

nlohmann::json StatusOf(const ServiceProcess& service) {
  const auto status = tools::FetchStatus(service.socket_path());
  EXPECT_TRUE(status.ok());
  return status.ok() ? *status : nlohmann::json();
}

void KillAndStartAgain(ServiceProcess& service) {
  service.Signal(SIGKILL);
  service.Wait();
  service.Start();
  ASSERT_TRUE(WaitUntilServing(service));
}

// The largest force during a time in which a pen that presses would be pushed.
double LargestForce_N(TestApplication& app) {
  double largest_N = 0;
  app.Run(kLong_ms, 5, [&] {
    largest_N = std::max(largest_N, app.connection().connected() ? app.Force_N() : 0);
    return false;
  });
  return largest_N;
}

TEST(ProcessSafety, EmergencyStopHoldsAfterServiceIsKilledAndStartedAgain) {
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.WaitForForce(kPushing_N));
  const Outcome stopped = Stop(service);
  EXPECT_EQ(stopped.status, 0) << stopped.err;
  EXPECT_NE(stopped.out.find("also after a restart"), std::string::npos) << stopped.out;
  EXPECT_TRUE(fs::exists(service.latch_path())) << "it is there before the answer";
  KillAndStartAgain(service);
  EXPECT_EQ(LargestForce_N(app), 0);
  const nlohmann::json status = StatusOf(service);
  EXPECT_EQ(status["stopped"], "omni");
  EXPECT_TRUE(status["stop"]["from_before"]);
  EXPECT_EQ(status["stop"]["latch"], "kept");
  EXPECT_NE(stopped.out.find(status["stop"]["at"].get<std::string>()), std::string::npos) << stopped.out;
  const Outcome released = Stop(service, {"--release"});
  EXPECT_EQ(released.status, 0) << released.err;
  EXPECT_FALSE(fs::exists(service.latch_path())) << "it is gone before the answer";
  EXPECT_TRUE(app.WaitForForce(kPushing_N));
  KillAndStartAgain(service);
  EXPECT_TRUE(app.WaitForForce(kPushing_N)) << "it was released";
}

TEST(ProcessSafety, ServiceThatEndsOrDiesWithoutEmergencyStopStartsWithForce) {
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.WaitForForce(kPushing_N));
  EXPECT_EQ(service.Stop(), 0);
  service.Start();
  EXPECT_TRUE(app.WaitForForce(kPushing_N));
  KillAndStartAgain(service);
  EXPECT_TRUE(app.WaitForForce(kPushing_N));
  EXPECT_TRUE(StatusOf(service)["stop"].is_null());
}

TEST(ProcessSafety, EmergencyStopWithoutADiskHoldsUntilServiceEndsAndSaysSo) {
  ServiceProcess service;
  service.Start({"--log-level", "warn", "--stop-file", "/dev/null/emergency_stop.toml"}, service.Path("log"));
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.WaitForForce(kPushing_N));
  const Outcome stopped = Stop(service);
  EXPECT_EQ(stopped.status, 0) << stopped.err;
  EXPECT_NE(stopped.out.find("until omnid ends: /dev/null/emergency_stop.toml"), std::string::npos) << stopped.out;
  app.Run(100, 5);
  EXPECT_EQ(LargestForce_N(app), 0);
  EXPECT_NE(StatusOf(service)["problems"].dump().find("forgotten when omnid ends"), std::string::npos);
  EXPECT_EQ(Stop(service, {"--release"}).status, 0);
  EXPECT_TRUE(app.WaitForForce(kPushing_N));
}

// Damaged, but there: the user wanted no force.
TEST(ProcessSafety, ServiceStartsStoppedByAnyLatch) {
  ServiceProcess service;
  fs::create_directories(service.latch_path());
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  EXPECT_EQ(LargestForce_N(app), 0);
  const Outcome released = Stop(service, {"--release"});
  EXPECT_EQ(released.status, 0) << released.err;
  EXPECT_NE(released.out.find("the next omnid starts stopped"), std::string::npos) << released.out;
  EXPECT_TRUE(app.WaitForForce(kPushing_N));
}

// Its base is a simulation of its own: neither a stop of the person's base nor one of the last trial is its concern.
TEST(ProcessSafety, TrialStartsReleasedAndKeepsItsStopToItself) {
  const TempFolder folder;
  const std::string latch =
      folder.Write("state/omni/emergency_stop.toml", "by = \"omni\"\nat = \"2026-01-31T12:00:00Z\"\n");
  fs::create_directory(folder.Path("run"));
  fs::permissions(folder.Path("run"), fs::perms::owner_all);
  const std::string omni = OMNI_BINARY_DIR "/bin/omni";
  auto trial = ChildProcess::Start(
      {omni, "try", "--no-open", "--seconds", "20"},
      {"XDG_STATE_HOME=" + folder.Path("state"), "XDG_RUNTIME_DIR=" + folder.Path("run"), "OMNI_SOCKET="},
      folder.Path("out"));
  ASSERT_TRUE(trial.ok());
  std::string socket;
  nlohmann::json status;
  for (int i = 0; i < 100 && status.is_null(); ++i) {
    SleepMs(100);
    for (const auto& entry : fs::directory_iterator(folder.Path("run"))) socket = entry.path() / "omnid.sock";
    const auto answer = tools::FetchStatus(socket);
    if (answer.ok()) status = *answer;
  }
  ASSERT_FALSE(status.is_null());
  EXPECT_TRUE(status["stopped"].is_null());
  const Outcome stopped = RunOmni({"stop", "--socket", socket});
  EXPECT_EQ(stopped.status, 0) << stopped.err;
  EXPECT_TRUE(fs::exists(fs::path(socket).parent_path() / "emergency_stop.toml")) << stopped.out;
  EXPECT_EQ(RunOmni({"stop", "--release", "--socket", socket}).status, 0);
  EXPECT_TRUE(fs::exists(latch)) << "the person's own stop stays";
  kill(trial->pid(), SIGTERM);
  EXPECT_EQ(trial->Wait(), 0);
}

}  // namespace test_process_stop
}  // namespace omni::test
