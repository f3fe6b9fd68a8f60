// A signal ends omnid within a second, whatever it is doing, with the coils at zero before.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "service/scene/glb_save.h"
#include "service/tools/common/service_link.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/service_end.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_end {

constexpr const char* kAwayHand = R"({"name": "away", "repeat": false, "waypoints": [
  {"s": 0, "tip_m": [0, 0, 0.085], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0, 0, 0.085], "axis": [0, 0, -1]}]})";

void ExpectGoodEnd(const ServiceEnd& end, int status = 0) {
  EXPECT_EQ(end.status, status);
  EXPECT_LT(end.ms, kEndsWithin_ms);
}

// A service whose twin process is stopped.
class StoppedTwin {
 public:
  StoppedTwin() {
    service.Start();
    EXPECT_TRUE(WaitUntilServing(service));
    SleepMs(300);
    twin_ = ChildOf(service.pid());
    EXPECT_GT(twin_, 0);
    if (twin_ > 0) kill(twin_, SIGSTOP);
  }
  ~StoppedTwin() {
    if (twin_ > 0) kill(twin_, SIGCONT);
  }
  StoppedTwin(const StoppedTwin&) = delete;
  StoppedTwin& operator=(const StoppedTwin&) = delete;

  ServiceProcess service;

 private:
  pid_t twin_ = 0;
};

// A disk that does not respond behaves like an unread pipe: `option` names it as the file to be written.
ServiceEnd EndWithUnreadFile(const std::string& option, const char* what) {
  ServiceProcess service;
  const UnreadPipe file(service.Path("file"), UnreadPipe::Reader::kSleeps);
  service.Start({option, file.path()}, {});
  EXPECT_TRUE(WaitUntilServing(service));
  TestApplication app(service);
  EXPECT_TRUE(app.Focus());
  app.Run(1500, 10);  // more than a pipe holds
  return EndAndWait(service, what);
}

// The shipped dragon's soft body takes a minute to compute.
TEST(ProcessEnd, ExitsInTimeWhileComputingSoftBody) {
  ServiceProcess service(OMNI_SOURCE_DIR "/scenes/dragon.glb", kAwayHand);
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.Run(20'000, 10, [&] {
    const auto status = tools::FetchStatus(service.socket_path());
    return status.ok() && (*status)["scene"]["soft_bodies"].is_object();
  }));
  app.Run(500, 10);
  ExpectGoodEnd(EndAndWait(service, "a soft body is being computed"));
}

// Each triangle with three vertices of its own.
haptics::InputObject Unwelded(const haptics::InputObject& object) {
  haptics::InputObject apart = object;
  apart.vertices_base_m.clear();
  for (auto& triangle : apart.triangles) {
    for (std::uint32_t& corner : triangle) {
      const auto index = static_cast<std::uint32_t>(apart.vertices_base_m.size());
      apart.vertices_base_m.push_back(object.vertices_base_m[corner]);
      corner = index;
    }
  }
  return apart;
}

TEST(ProcessEnd, ExitsInTimeWhileLoading100MegabyteScene) {
  const TempFolder folder;
  const std::string file = folder.Path("ball.glb");
  haptics::InputObject ball = haptics::Sphere(325, 0.02);
  for (base::Vec3& v : ball.vertices_base_m) v.z += 0.06;
  const auto saved = scene::SaveGlb(file, haptics::SceneOf(Unwelded(ball)));
  ASSERT_TRUE(saved.ok()) << saved.error();
  std::printf("[ figure   ] the scene has %.0f MB\n", 1e-6 * static_cast<double>(std::filesystem::file_size(file)));
  ASSERT_GT(std::filesystem::file_size(file), 100'000'000U);
  ServiceProcess service(file, kAwayHand);
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  app.Run(300, 10);
  ExpectGoodEnd(EndAndWait(service, "a large scene is being loaded"));
}

TEST(ProcessEnd, ExitsInTimeWithStoppedTwin) {
  StoppedTwin stopped;
  ExpectGoodEnd(EndAndWait(stopped.service, "its twin is stopped"));
}

TEST(ProcessEnd, SecondSignalEndsAtOnce) {
  StoppedTwin stopped;
  stopped.service.Signal(SIGTERM);
  SleepMs(100);
  const ServiceEnd end = EndAndWait(stopped.service, "the second signal");
  EXPECT_EQ(end.status, 0);
  EXPECT_LT(end.ms, 500);
}

TEST(ProcessEnd, ExitsInTimeWithBlockedRecording) {
  ExpectGoodEnd(EndWithUnreadFile("--record", "its recording is an unread pipe"), 1);
}

TEST(ProcessEnd, ExitsInTimeWithBlockedDeviceRecording) {
  ExpectGoodEnd(EndWithUnreadFile("--record-device", "its device recording is an unread pipe"), 1);
}

// Main itself waits here, as it may for a base on USB.
TEST(ProcessEnd, ExitsInTimeWhileMainThreadIsBlocked) {
  ServiceProcess service;
  const UnreadPipe file(service.Path("loop.csv"), UnreadPipe::Reader::kNone);
  service.Start({"--record", file.path()}, {});
  ASSERT_TRUE(WaitUntilServing(service));
  SleepMs(300);
  ExpectGoodEnd(EndAndWait(service, "main waits for a file to open"));
}

TEST(ProcessEnd, ForcedExitZeroesCoilsWithin50Milliseconds) {
  ServiceProcess service;
  const UnreadPipe file(service.Path("loop.csv"), UnreadPipe::Reader::kSleeps);
  service.Start({"--record", file.path()}, {});
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.WaitForForce(0.2));
  app.Run(500, 10);
  const std::int64_t asked_ns = base::MonotonicNow_ns();
  ExpectGoodEnd(EndAndWait(service, "it pushes, and its recording is an unread pipe"), 1);
  const auto truth = service.Truth();
  ASSERT_TRUE(truth.has_value());
  EXPECT_GT(MillisecondsToZero(*truth, asked_ns - 20'000'000, 20), 0) << "it was pushing before";
  EXPECT_LE(MillisecondsToZero(*truth, asked_ns, kWholeRecording_ms), 50);
}

}  // namespace test_process_end
}  // namespace omni::test
