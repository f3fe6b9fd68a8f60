// The service between clients and the loop: scenes are built, swapped in at a tick, dropped with their client.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/config/device_file.h"
#include "service/daemon/service.h"
#include "service/loop/tick_config.h"

namespace omni::daemon {
namespace {

using protocol::SessionState;

// Scans without a pen, every millisecond.
class QuietDevice : public device::Transport {
 public:
  device::ReadStatus Read(base::HallScan& scan, std::int64_t /*timeout_ns*/) noexcept override {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    scan = {};
    scan.sequence = ++sequence_;
    scan.t_ns = base::MonotonicNow_ns();
    return device::ReadStatus::kScan;
  }
  bool Write(const base::CoilCurrents& /*currents*/) noexcept override { return true; }
  const device::TransportInfo& info() const noexcept override { return info_; }
  device::TransportCounters counters() const noexcept override { return {}; }

 private:
  device::TransportInfo info_{.name = "quiet"};
  std::uint64_t sequence_ = 0;
};

class DeviceSource : public loop::TickSource {
 public:
  explicit DeviceSource(device::Transport& transport) : transport_(transport) {}
  loop::WaitStatus Wait(base::HallScan& scan) noexcept override {
    transport_.Read(scan, 0);
    return loop::WaitStatus::kTick;
  }
  void Apply(const base::CoilCurrents& currents) noexcept override { transport_.Write(currents); }

 private:
  device::Transport& transport_;
};

struct NoSink : loop::TickSink {
  void Publish(const loop::TickOutput& /*output*/) noexcept override {}
};

class ServiceTest : public testing::Test {
 protected:
  ServiceTest()
      : source_(device_), service_({.version = "test", .instance = 1, .apps = Apps(), .hull_radius_m = 0.0375}) {
    loop_ = std::make_unique<loop::TickThread>(loop::MakeTickConfig(config::DefaultDevice()),
                                               loop::TickThread::Options{.realtime = false}, source_, sink_);
    loop_->Start();
    service_.Attach(*loop_, device_);
  }
  ~ServiceTest() override {
    service_.Detach("the test is over");
    loop_->Stop();
  }

  static config::AppTable Apps() {
    const std::string scenes = std::string(OMNI_SOURCE_DIR) + "/scenes/";
    config::AppTable table;
    table.entries.push_back({.application_glob = "block*", .scene = scenes + "extrusion.glb"});
    table.entries.push_back({.application_glob = "track*", .scene = scenes + "racetrack.glb"});
    table.entries.push_back({.application_glob = "broken*", .scene = scenes + "not_there.glb"});
    return table;
  }

  void Connect(std::uint64_t id, const std::string& application) {
    service_.OnClient({.id = id, .role = protocol::ClientRole::kApplication, .pid = 1, .application = application});
  }
  void Focus(std::uint64_t id) {
    service_.OnSession(id, SessionState::kBegun);
    service_.OnSession(id, SessionState::kFocused);
  }
  nlohmann::json Status() { return nlohmann::json::parse(service_.StatusJson()); }
  std::uint64_t InTheTick() { return loop_->statistics().scene_generation.load(); }

  // Runs the control thread's period until `holds`, for at most 10 s.
  bool Until(const std::function<bool()>& holds) {
    for (int i = 0; i < 2000; ++i) {
      service_.OnPeriod(base::MonotonicNow_ns());
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  QuietDevice device_;
  DeviceSource source_;
  NoSink sink_;
  Service service_;
  std::unique_ptr<loop::TickThread> loop_;
};

TEST_F(ServiceTest, SceneIsBuiltSwappedInAndDroppedWithTheSession) {
  Connect(1, "block 1");
  Focus(1);
  ASSERT_TRUE(Until([&] { return InTheTick() != 0; }));
  EXPECT_EQ(Status()["scene"]["triangles"], 1608);
  EXPECT_TRUE(Status()["clients"][0]["owner"]);
  service_.OnSession(1, SessionState::kNone);
  EXPECT_TRUE(Until([&] { return InTheTick() == 0; }));
  EXPECT_EQ(Status()["scene"]["triangles"], 0);
}

TEST_F(ServiceTest, EachClientKeepsItsSceneAndTheOwnersIsInTheTick) {
  Connect(1, "block 1");
  Connect(2, "track 1");
  Focus(1);
  ASSERT_TRUE(Until([&] { return InTheTick() != 0; }));
  const std::uint64_t block = InTheTick();
  Focus(2);
  ASSERT_TRUE(Until([&] { return InTheTick() > block; }));
  service_.OnGone(2);
  EXPECT_TRUE(Until([&] { return InTheTick() == block; })) << "the first one's scene is still there, not built again";
  service_.OnGone(1);
  EXPECT_TRUE(Until([&] { return InTheTick() == 0; }));
  EXPECT_TRUE(Status()["clients"].empty());
}

TEST_F(ServiceTest, ASceneThatDoesNotLoadIsAProblemAndOthersLiveOn) {
  Connect(1, "block 1");
  Focus(1);
  ASSERT_TRUE(Until([&] { return InTheTick() != 0; }));
  Connect(2, "broken 1");
  service_.OnSession(2, SessionState::kBegun);
  ASSERT_TRUE(Until([&] { return !Status()["problems"].empty(); }));
  EXPECT_NE(Status()["problems"][0].get<std::string>().find("not_there.glb"), std::string::npos);
  EXPECT_NE(InTheTick(), 0U);
}

TEST_F(ServiceTest, UnknownApplicationHasNoScene) {
  Connect(1, "somebody else");
  Focus(1);
  EXPECT_FALSE(Until([&, i = 0]() mutable { return InTheTick() != 0 || ++i > 50; }) && InTheTick() != 0);
  EXPECT_TRUE(Status()["clients"][0]["owner"]) << "it still gets poses and vibration";
}

TEST_F(ServiceTest, UnknownClientsAreIgnored) {
  Connect(1, "a");
  Focus(1);
  service_.OnHaptic(99, {});
  service_.OnHapticStop(99);
  service_.OnSession(99, SessionState::kFocused);
  service_.OnGone(99);
  EXPECT_EQ(Status()["clients"].size(), 1U);
  EXPECT_TRUE(Status()["clients"][0]["owner"]);
}

TEST_F(ServiceTest, StatusSaysWhatIsThere) {
  const nlohmann::json status = Status();
  for (const char* key : {"service", "device", "clients", "scene", "aligned", "problems", "tick"}) {
    EXPECT_TRUE(status.contains(key)) << key;
  }
  EXPECT_EQ(status["aligned"], false);
  EXPECT_EQ(status["device"]["name"], "quiet");
  service_.Detach("unplugged");
  EXPECT_EQ(Status()["device"]["absent"], "unplugged");
  service_.Attach(*loop_, device_);
}

}  // namespace
}  // namespace omni::daemon
