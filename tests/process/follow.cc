// A base that moves, from end to end: the in-repo runtime with a scripted controller, the probe, `omni follow` and
// omnid as real processes; then what an application reads.
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "service/alignment/rigid.h"
#include "service/config/files/follow_file.h"
#include "service/protocol/text.h"
#include "service/tools/align/align.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_follow {

using alignment::Rigid;

constexpr int kPatience_ms = 60'000;  // ends what hangs
constexpr double kTurn_rad_s = 1.5708;
const base::Vec3 kVelocity_m_s{0.3, 0, 0.4};

// In STAGE, while both rest.
Rigid BaseAtRest() { return alignment::NudgedPose(alignment::LevelBase(), 0.4, {0.3, 0.75, -0.6}); }
Rigid ControllerAtRest() { return {.orientation = {0.6, 0, 0.8, 0}, .position_m = {0.2, 0.9, -0.5}}; }

// Rests for 10 s from the start of the session, moves for 3 s, and is lost.
std::string Script() {
  const Rigid C = ControllerAtRest();
  const std::string pose =
      tools::Format("pose /user/hand/left/input/grip/pose %.6f %.6f %.6f %.7f %.7f %.7f %.7f", C.position_m.x,
                    C.position_m.y, C.position_m.z, C.orientation.x, C.orientation.y, C.orientation.z, C.orientation.w);
  return "0 " + pose + "\n10 " + pose +
         tools::Format(" %.3f %.3f %.3f 0 %.6f 0\n", kVelocity_m_s.x, kVelocity_m_s.y, kVelocity_m_s.z, kTurn_rad_s) +
         "13 tracking left 0 0\n";
}

// As `omni align` does at its end.
void StoreAlignment(const ServiceProcess& service) {
  auto tool = tools::ConnectToService(service.socket_path(), protocol::ClientRole::kTool);
  ASSERT_TRUE(tool.ok()) << tool.error();
  alignment::Outcome outcome;
  outcome.base_space = BaseAtRest();
  outcome.samples = 5;
  outcome.expected_error_m = 1e-3;
  const tools::Headset headset{
      .runtime = "Omni test runtime", .system = "Omni test system", .space = protocol::kSpaceStage};
  const auto stored = tools::RequestBasePose(**tool, tools::StoreCommand(headset, outcome, "touch"));
  ASSERT_TRUE(stored.ok()) << stored.error();
}

base::Vec3 Vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

// An application that reads where the base is.
class Watcher {
 public:
  explicit Watcher(const ServiceProcess& service) : application_(service) {
    EXPECT_TRUE(application_.Focus());
    protocol::BasePoseRequest request;
    protocol::SetField(request.headset.runtime, "Omni test runtime");
    protocol::SetField(request.headset.system, "Omni test system");
    request.space_count = 1;
    request.spaces = {protocol::kSpaceStage};
    application_.connection().RequestBasePose(request);
  }
  bool IsNotified(std::uint32_t follows) {
    return application_.Run(kPatience_ms, 5, [&] {
      const auto pose = application_.connection().PopBasePose();
      return pose && pose->follows == follows;
    });
  }
  template <class Wanted>
  bool Until(Wanted wanted) {
    return application_.Run(kPatience_ms, 2, [&] {
      const auto state = application_.connection().state();
      return state != nullptr && state->ReadNewest(sample) && wanted(sample);
    });
  }
  protocol::BaseSample sample;

 private:
  TestApplication application_;
};

TEST(ProcessFollow, MountedBaseFollowsItsController) {
  const std::string build = OMNI_BINARY_DIR;
  const TempFolder temp;
  ServiceProcess service;
  service.Start();
  ASSERT_GT(service.pid(), 0);
  Watcher watcher(service);
  StoreAlignment(service);
  auto follow = ChildProcess::Start(
      {build + "/bin/omni", "follow", "/user/hand/left", "--mount", "--file", temp.Path("follow.toml"), "--probe",
       build + "/bin/omni_align_probe", "--socket", service.socket_path()},
      {"XR_RUNTIME_JSON=" + build + "/share/openxr/1/omni_test_runtime.json",
       "OMNI_TEST_RUNTIME_SCRIPT=" + temp.Write("follow.script", Script())},
      temp.Path("follow.txt"));
  ASSERT_TRUE(follow.ok()) << follow.error();
  ASSERT_TRUE(watcher.IsNotified(1));
  ASSERT_TRUE(watcher.Until([](const auto& sample) { return sample.flags == protocol::kBaseSeen; }));
  EXPECT_EQ(watcher.sample.space, protocol::kSpaceStage);
  EXPECT_LT(base::Distance(Vector(watcher.sample.position_space_m), BaseAtRest().position_m), 1e-5)
      << "at rest it is where it was aligned";

  const auto moves = [](const auto& sample) { return std::abs(sample.angular_velocity_space_rad_s[1]) > 1; };
  ASSERT_TRUE(watcher.Until(moves));
  for (int i = 0; i < 50; ++i) {
    const protocol::BaseSample before = watcher.sample;
    ASSERT_TRUE(watcher.Until([&](const auto& sample) { return sample.t_ns > before.t_ns; }));
    const protocol::BaseSample after = watcher.sample;
    if (after.flags != protocol::kBaseSeen || after.t_ns - before.t_ns > 50'000'000) continue;  // a busy computer
    EXPECT_NEAR(after.angular_velocity_space_rad_s[1], kTurn_rad_s, 1e-3);
    const double dt_s = 1e-9 * static_cast<double>(after.t_ns - before.t_ns);
    const base::Vec3 v = 0.5 * (Vector(before.linear_velocity_space_m_s) + Vector(after.linear_velocity_space_m_s));
    EXPECT_LT(base::Distance(Vector(after.position_space_m), Vector(before.position_space_m) + dt_s * v), 2e-5);
    const base::Vec3 of_lever = Vector(after.linear_velocity_space_m_s) - kVelocity_m_s;
    EXPECT_GT(base::Norm(of_lever), 0.1) << "the controller turns 0.2 m beside the base";
  }
  EXPECT_TRUE(watcher.Until([](const auto& sample) { return sample.flags == 0; })) << "the controller is lost";

  ASSERT_EQ(kill(follow->pid(), SIGINT), 0);
  EXPECT_EQ(follow->Wait(), 0);
  std::ifstream file(temp.Path("follow.txt"));
  const std::string said{std::istreambuf_iterator<char>(file), {}};
  for (const char* part : {"mounted", "/user/hand/left: the base follows it", "is not tracked"}) {
    EXPECT_NE(said.find(part), std::string::npos) << part << " not in: " << said;
  }
  const auto kept = config::LoadFollowFile(temp.Path("follow.toml"));
  ASSERT_TRUE(kept.ok() && *kept);
  const Rigid mount{.orientation = (*kept)->orientation_source, .position_m = (*kept)->position_source_m};
  const Rigid truth = alignment::Compose(alignment::Inverse(ControllerAtRest()), BaseAtRest());
  EXPECT_LT(alignment::Distance_m(mount, truth, {}), 1e-5);
  EXPECT_LT(alignment::Angle_rad(mount, truth), 1e-5);

  auto off = ChildProcess::Start(
      {build + "/bin/omni", "follow", "--off", "--file", temp.Path("follow.toml"), "--socket", service.socket_path()},
      {});
  ASSERT_TRUE(off.ok()) << off.error();
  EXPECT_EQ(off->Wait(), 0);
  EXPECT_TRUE(watcher.IsNotified(0)) << "it stands where it was aligned";
  EXPECT_FALSE(std::filesystem::exists(temp.Path("follow.toml")));
}

}  // namespace test_process_follow
}  // namespace omni::test
