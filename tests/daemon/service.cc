// The service between clients and the loop: scenes are built, swapped in at a tick, dropped with their client.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <random>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/config/files/device_file.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/service.h"
#include "service/loop/tick_config.h"
#include "tests/support/held_pen.h"
#include "tests/support/silent_device.h"

namespace omni::daemon {
namespace test_daemon_service {

protocol::Session SessionOf(protocol::SessionState state) {
  protocol::Session session;
  session.state = state;
  return session;
}

using protocol::SessionState;

struct NoSink : loop::TickSink {
  void Publish(const loop::TickOutput& /*output*/, const base::HallScan& /*scan*/,
               const loop::TickTimes& /*times*/) noexcept override {}
};

class ServiceTest : public testing::Test {
 protected:
  explicit ServiceTest(std::unique_ptr<device::Transport> device = std::make_unique<support::SilentDevice>())
      : device_(std::move(device)),
        source_(*device_),
        service_({.version = "test", .instance = 1, .apps = Apps(), .inputs = Plan(), .hull_radius_m = 0.0375}) {
    loop_ = std::make_unique<loop::TickThread>(loop::MakeTickConfig(config::DefaultDevice()),
                                               loop::TickThread::Options{.realtime = false}, source_, sink_);
    loop_->Start();
    service_.device().Attach(*loop_, *device_);
  }
  ~ServiceTest() override { service_.device().Detach("the test is over"); }

  static config::AppTable Apps() {
    const std::string scenes = std::string(OMNI_SOURCE_DIR) + "/scenes/";
    config::AppTable table;
    table.entries.push_back({.application_glob = "block*", .scene = scenes + "extrusion.glb"});
    table.entries.push_back({.application_glob = "track*", .scene = scenes + "racetrack.glb"});
    table.entries.push_back({.application_glob = "broken*", .scene = scenes + "not_there.glb"});
    config::InputTable keys;
    keys.mapping.at(base::InputComponent::kMenu).plus = base::KeyBit(0);
    keys.keys = {48};  // KEY_B
    table.entries.push_back({.application_glob = "keys*", .inputs = keys});
    return table;
  }
  static config::InputPlan Plan() { return {.devices = {}, .fallback = {}, .slots = {48}, .file = {}}; }

  void Connect(std::uint64_t id, const std::string& application) {
    service_.OnClient({.id = id, .role = protocol::ClientRole::kApplication, .pid = 1, .application = application});
  }
  void Focus(std::uint64_t id) {
    service_.OnRequest(id, SessionOf(SessionState::kBegun), {});
    service_.OnRequest(id, SessionOf(SessionState::kFocused), {});
  }
  nlohmann::json Status() { return nlohmann::json::parse(service_.StatusJson()); }
  // Name of the scene's file that the tick has taken, "" for the empty one, "?" while it still has another one.
  std::string InTheTick() {
    const nlohmann::json scene = Status()["scene"];
    if (scene["generation"] != loop_->statistics().scene_generation.load()) return "?";
    return std::filesystem::path(scene["name"].get<std::string>()).filename().string();
  }

  // Runs the control thread's period until `holds`, for at most 10 s.
  bool Until(const std::function<bool()>& holds) {
    for (int i = 0; i < 2000; ++i) {
      service_.OnPeriod(base::MonotonicNow_ns());
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  std::unique_ptr<device::Transport> device_;
  TransportTickSource source_;
  NoSink sink_;
  Service service_;
  std::unique_ptr<loop::TickThread> loop_;
};

TEST_F(ServiceTest, SceneIsLoadedAndDroppedWithTheSession) {
  Connect(1, "block 1");
  Focus(1);
  ASSERT_TRUE(Until([&] { return InTheTick() == "extrusion.glb"; }));
  EXPECT_EQ(Status()["scene"]["triangles"], 1608);
  EXPECT_TRUE(Status()["clients"][0]["owner"]);
  service_.OnRequest(1, SessionOf(SessionState::kNone), {});
  EXPECT_TRUE(Until([&] { return InTheTick().empty(); }));
  EXPECT_EQ(Status()["scene"]["triangles"], 0);
}

// The owner's mapping is active, and keys reach the tick.
TEST_F(ServiceTest, UsesTheOwnersInputMapping) {
  EXPECT_EQ(Status()["inputs"]["mapping"]["menu"], nlohmann::json({"flick"}));
  Connect(1, "keys 1");
  Focus(1);
  service_.OnPeriod(base::MonotonicNow_ns());
  EXPECT_EQ(Status()["inputs"]["mapping"]["menu"], nlohmann::json({"key:KEY_B"}));
  EXPECT_TRUE(Status()["scene"]["name"].get<std::string>().empty()) << "a file about inputs only";
  const auto times = [&](const std::string& name) {
    const nlohmann::json status = Status();
    for (const auto& source : status["inputs"]["sources"]) {
      if (source["name"] == name) return source["times"].get<int>();
    }
    return -1;
  };
  ASSERT_TRUE(Until([&] { return loop_->statistics().ticks.load() > 5; }));
  EXPECT_EQ(times("key:KEY_B"), 0);
  EXPECT_EQ(times("tap"), 0);
  base::KeyStates keys;
  keys.slots[0] = {.press_count = 1, .release_count = 0, .t_press_ns = base::MonotonicNow_ns(), .t_release_ns = 0};
  service_.device().SetKeys(keys);
  EXPECT_TRUE(Until([&] { return times("key:KEY_B") == 1; }));
  service_.OnRequest(1, SessionOf(SessionState::kBegun), {});
  EXPECT_EQ(Status()["inputs"]["mapping"]["menu"], nlohmann::json({"flick"}));
  EXPECT_TRUE(Status()["inputs"]["devices"].empty());
}

// Of each kind, and only those of the owner.
TEST_F(ServiceTest, OnlyTheOwnersVibrationsReachTheTick) {
  Connect(1, "silent 1");
  Connect(2, "silent 2");
  Focus(1);
  loop_->Stop();  // from here on the test reads what the tick would
  const auto haptic = [&] { return loop_->commands().Read().haptic; };
  const std::vector<float> samples(200, 0.5F);
  protocol::ShapedHaptic shaped;
  shaped.waveform.count = 200;
  shaped.waveform.duration_ns = 500'000'000;
  shaped.bytes = {reinterpret_cast<const char*>(samples.data()), samples.size() * sizeof(float)};
  service_.OnRequest(2, shaped, {});
  EXPECT_FALSE(haptic().active) << "it does not own the force";
  service_.OnRequest(1, shaped, {});
  EXPECT_TRUE(haptic().active);
  EXPECT_EQ(haptic().kind, loop::VibrationKind::kEnvelope);
  EXPECT_EQ(loop_->vibration().Read().id, haptic().id);
  EXPECT_EQ(loop_->vibration().Read().count, 200U);
  EXPECT_EQ(loop_->vibration().Read().values[199], 0.5F);
  shaped.waveform.kind = protocol::WaveformKind::kPcm;
  shaped.waveform.duration_ns = 0;
  shaped.waveform.sample_rate_Hz = 1000;
  service_.OnRequest(1, shaped, {});
  const std::uint64_t id = haptic().id;
  EXPECT_EQ(loop_->vibration().Read().id, id);
  shaped.waveform.append = 1;
  service_.OnRequest(1, shaped, {});
  EXPECT_EQ(haptic().id, id) << "appended samples are not a new vibration";
  EXPECT_EQ(loop_->vibration().Read().count, 400U);
  service_.OnRequest(1, protocol::Haptic{.duration_ns = 500'000'000, .amplitude = 1}, {});
  EXPECT_EQ(haptic().kind, loop::VibrationKind::kTone);
  EXPECT_EQ(haptic().id, id + 1) << "the later replaces the earlier";
  service_.OnRequest(1, SessionOf(SessionState::kBegun), {});
  EXPECT_FALSE(haptic().active) << "without focus nothing vibrates";
}

TEST_F(ServiceTest, TickUsesTheOwnersScene) {
  Connect(1, "block 1");
  Connect(2, "track 1");
  Focus(1);
  ASSERT_TRUE(Until([&] { return InTheTick() == "extrusion.glb"; }));
  Focus(2);
  ASSERT_TRUE(Until([&] { return InTheTick() == "racetrack.glb"; }));
  EXPECT_TRUE(Until([&] { return Status()["race"].is_object(); })) << "its car";
  EXPECT_EQ(Status()["race"]["laps"], 0);
  service_.OnGone(2);
  service_.OnPeriod(base::MonotonicNow_ns());
  EXPECT_EQ(Status()["scene"]["name"], Status()["clients"][0]["scene"]) << "still there, not built again";
  EXPECT_TRUE(Until([&] { return InTheTick() == "extrusion.glb"; }));
  EXPECT_TRUE(Until([&] { return Status()["race"].is_null(); })) << "no car any more";
  service_.OnGone(1);
  EXPECT_TRUE(Until([&] { return InTheTick().empty(); }));
  EXPECT_TRUE(Status()["clients"].empty());
}

TEST_F(ServiceTest, SceneThatFailsToLoadIsReportedAndOthersStay) {
  Connect(1, "block 1");
  Focus(1);
  ASSERT_TRUE(Until([&] { return InTheTick() == "extrusion.glb"; }));
  Connect(2, "broken 1");
  service_.OnRequest(2, SessionOf(SessionState::kBegun), {});
  ASSERT_TRUE(Until([&] { return !Status()["problems"].empty(); }));
  EXPECT_NE(Status()["problems"][0].get<std::string>().find("not_there.glb"), std::string::npos);
  EXPECT_EQ(InTheTick(), "extrusion.glb");
}

TEST_F(ServiceTest, UnknownApplicationHasNoScene) {
  Connect(1, "somebody else");
  Focus(1);
  EXPECT_TRUE(Until([&, i = 0]() mutable { return ++i > 50; }));
  EXPECT_EQ(InTheTick(), "");
  EXPECT_TRUE(Status()["clients"][0]["owner"]) << "it still gets poses and vibration";
}

TEST_F(ServiceTest, UnknownClientsAreIgnored) {
  Connect(1, "a");
  Focus(1);
  service_.OnRequest(99, protocol::Haptic{}, {});
  service_.OnRequest(99, protocol::HapticStop{}, {});
  service_.OnRequest(99, SessionOf(SessionState::kFocused), {});
  service_.OnGone(99);
  EXPECT_EQ(Status()["clients"].size(), 1U);
  EXPECT_TRUE(Status()["clients"][0]["owner"]);
}

TEST_F(ServiceTest, StatusHasAllSectionsAndTheDeviceState) {
  const nlohmann::json status = Status();
  for (const char* key : {"service", "device", "calibration", "clients", "scene", "aligned", "problems", "tick"}) {
    EXPECT_TRUE(status.contains(key)) << key;
  }
  EXPECT_EQ(status["aligned"], false);
  EXPECT_EQ(status["device"]["name"], "quiet");
  EXPECT_EQ(status["device"]["state"], "boot") << "it has not reported its state";
  service_.device().Detach("unplugged");
  EXPECT_EQ(Status()["device"]["absent"], "unplugged");
  EXPECT_TRUE(loop_->finished());
}

TEST(ServiceCalibration, StatusNamesTheCalibrationOrWhyThereIsNone) {
  config::CalibrationChoice used{.file = config::CalibrationFile{}, .path = "/c/calibration.toml"};
  used.file->date = "2026-11-21T09:00:00Z";
  Service calibrated({.version = "test", .instance = 1, .hull_radius_m = 0.0375, .calibration = used});
  const nlohmann::json with = nlohmann::json::parse(calibrated.StatusJson());
  EXPECT_EQ(with["calibration"]["file"], "/c/calibration.toml");
  EXPECT_EQ(with["calibration"]["date"], "2026-11-21T09:00:00Z");
  EXPECT_TRUE(with["problems"].empty());

  Service refused(
      {.version = "test",
       .instance = 1,
       .hull_radius_m = 0.0375,
       .calibration = {.path = "/c/calibration.toml", .problem = "/c/calibration.toml:4: of another base"}});
  const nlohmann::json without = nlohmann::json::parse(refused.StatusJson());
  EXPECT_TRUE(without["calibration"].is_null());
  ASSERT_EQ(without["problems"].size(), 1U);
  EXPECT_NE(without["problems"][0].get<std::string>().find("of another base"), std::string::npos);
}

class HeldPenTest : public ServiceTest {
 protected:
  HeldPenTest() : ServiceTest(std::make_unique<support::HeldPen>()) {}
};

// Sanitizers watch: a scene must not be freed while the tick reads it or is about to take it.
TEST_F(HeldPenTest, ScenesAreFreedSafelyWhileTheTickIsInContact) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> wait_us(0, 4000);
  Connect(1, "block 1");
  for (int i = 0; i < 200; ++i) {
    Focus(1);
    Until([&] { return i % 4 != 0 || InTheTick() == "extrusion.glb"; });
    std::this_thread::sleep_for(std::chrono::microseconds(wait_us(random)));
    service_.OnRequest(1, SessionOf(SessionState::kNone), {});
    service_.OnPeriod(base::MonotonicNow_ns());
  }
  Focus(1);
  ASSERT_TRUE(Until([&] { return InTheTick() == "extrusion.glb"; }));
  service_.device().Detach("unplugged");  // while the scene is touched
  service_.OnRequest(1, SessionOf(SessionState::kNone), {});
  service_.OnPeriod(base::MonotonicNow_ns());
}

}  // namespace test_daemon_service
}  // namespace omni::daemon
