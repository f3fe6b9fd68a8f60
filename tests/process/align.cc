// A base is aligned from end to end: omnid, the twin, the in-repo runtime with a scripted controller, the probe and the
// command line as real processes; then what an application gets, after a restart too.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <Eigen/Geometry>

#include "service/alignment/rigid.h"
#include "service/base/eigen.h"
#include "service/config/files/alignment_file.h"
#include "service/config/files/device_file.h"
#include "service/protocol/text.h"
#include "service/tools/align/align.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_align {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Where the base really stands, in STAGE.
alignment::Rigid TrueBase() { return alignment::NudgedPose(alignment::LevelBase(), 0.4, {0.3, 0.75, -0.6}); }

// The left controller's grip, line by line: swings about mark 1, then rests on each of the others.
std::string TouchScript() {
  const Vector3d tip(0.02, -0.01, -0.11);
  const auto& marks = config::DefaultMarks();
  const auto at = [&](std::size_t i) {
    return base::ToEigen(alignment::TransformPoint(TrueBase(), marks[i].position_base_m));
  };
  constexpr double kStart_s = 0.5, kSwing_s = 12, kMove_s = 0.8, kRest_s = 1.2, kStep_s = 0.02;
  std::string script;
  const double end_s = kSwing_s + static_cast<double>(marks.size() - 1) * (kMove_s + kRest_s);
  for (double t = 0; t < end_s; t += kStep_s) {
    Vector3d p = at(0);
    double swing = 0.5;
    if (t > kSwing_s) {
      const auto leg = static_cast<std::size_t>((t - kSwing_s) / (kMove_s + kRest_s));
      const double u = std::min(1.0, std::fmod(t - kSwing_s, kMove_s + kRest_s) / kMove_s);
      p = at(leg) + u * (at(leg + 1) - at(leg)) + Vector3d(0, 0.05 * std::sin(3.14159265 * u), 0);
      swing = 0.1;
    }
    const Vector3d w = swing * Vector3d(std::sin(2.1 * t), std::sin(1.7 * t + 1), std::sin(2.7 * t + 2));
    const Quaterniond q(Eigen::AngleAxisd(w.norm(), w.normalized()));
    const Vector3d c = p - q * tip;
    script += tools::Format("%.3f pose /user/hand/left/input/grip/pose %.6f %.6f %.6f %.7f %.7f %.7f %.7f\n",
                            kStart_s + t, c.x(), c.y(), c.z(), q.x(), q.y(), q.z(), q.w());
  }
  return script;
}

Outcome OmniAlign(const ServiceProcess& service, std::vector<std::string> words) {
  words.insert(words.begin(), "align");
  words.insert(words.end(), {"--socket", service.socket_path()});
  return RunOmni(words);
}

// The base_pose that an application on that headset receives.
std::optional<protocol::BasePose> BasePoseOf(const ServiceProcess& service, TestApplication& application) {
  protocol::BasePoseRequest request;
  protocol::SetField(request.headset.runtime, "Omni test runtime");
  protocol::SetField(request.headset.system, "Omni test system");
  request.space_count = 2;
  request.spaces = {protocol::kSpaceStage, protocol::kSpaceLocal};
  application.connection().RequestBasePose(request);
  std::optional<protocol::BasePose> base_pose;
  application.Run(5000, 5, [&] {
    base_pose = application.connection().PopBasePose();
    return base_pose.has_value();
  });
  (void)service;
  return base_pose;
}

bool AlignedFlag(TestApplication& application) {
  return application.Run(3000, 5, [&] {
    const auto state = application.connection().state();
    protocol::ToolSample sample;
    return state != nullptr && state->ReadNewest(sample) && (sample.flags & protocol::kToolAligned) != 0;
  });
}

TEST(ProcessAlign, TouchAlignmentReachesApplicationsAndSurvivesRestart) {
  const std::string build = OMNI_BINARY_DIR;
  const TempFolder temp;
  setenv("XR_RUNTIME_JSON", (build + "/share/openxr/1/omni_test_runtime.json").c_str(), 1);
  setenv("OMNI_TEST_RUNTIME_SCRIPT", temp.Write("touch.script", TouchScript()).c_str(), 1);
  ServiceProcess service;
  service.Start();
  ASSERT_GT(service.pid(), 0);
  {
    TestApplication before(service);
    ASSERT_TRUE(before.Focus());
    const auto base_pose = BasePoseOf(service, before);
    ASSERT_TRUE(base_pose);
    EXPECT_EQ(base_pose->known, 0U);
  }
  const Outcome aligned =
      OmniAlign(service, {"touch", "--hand", "left", "--probe", build + "/bin/omni_align_probe", "--patience", "60"});
  unsetenv("OMNI_TEST_RUNTIME_SCRIPT");
  ASSERT_EQ(aligned.status, 0) << aligned.out << aligned.err;
  for (const char* part : {"Omni test system", "STAGE", "expected", "good", "stored"}) {
    EXPECT_NE(aligned.out.find(part), std::string::npos) << part << " not in: " << aligned.out;
  }

  const auto folder = std::filesystem::path(service.socket_path()).parent_path().parent_path();
  const auto file = config::LoadAlignmentFile((folder / "config/omni/alignments.toml").string());
  ASSERT_TRUE(file.ok()) << file.error();
  ASSERT_EQ(file->entries.size(), 1U);
  const config::AlignmentEntry& entry = file->entries[0];
  const alignment::Rigid found{.orientation = entry.orientation_space, .position_m = entry.position_space_m};
  EXPECT_LT(alignment::Distance_m(found, TrueBase(), alignment::kWorkingPoint_base_m), 1e-3);
  EXPECT_LT(alignment::Angle_rad(found, TrueBase()), 0.01);
  EXPECT_EQ(entry.space, protocol::kSpaceStage);
  EXPECT_EQ(entry.runtime, "Omni test runtime");

  for (int start = 0; start < 2; ++start) {
    {
      TestApplication application(service);
      ASSERT_TRUE(application.Focus());
      const auto base_pose = BasePoseOf(service, application);
      ASSERT_TRUE(base_pose);
      EXPECT_EQ(base_pose->known, 1U);
      EXPECT_EQ(base_pose->base_space.position_m[0], entry.position_space_m.x);
      EXPECT_TRUE(AlignedFlag(application));
    }
    ASSERT_EQ(service.Stop(), 0);
    service.Start();
  }
  TestApplication other(service);
  ASSERT_TRUE(other.Focus());
  const Outcome shown = OmniAlign(service, {"--show"});
  EXPECT_NE(shown.out.find("1  Omni test runtime / Omni test system in STAGE: touch"), std::string::npos) << shown.out;
  EXPECT_EQ(OmniAlign(service, {"--forget", "--number", "1"}).status, 0);
  EXPECT_NE(OmniAlign(service, {"--show"}).out.find("no alignment is stored"), std::string::npos);
}

// As `omni align` does at its end.
void StoreInStage(const ServiceProcess& service) {
  auto connection = tools::ConnectToService(service.socket_path(), protocol::ClientRole::kTool);
  ASSERT_TRUE(connection.ok()) << connection.error();
  alignment::Outcome outcome;
  outcome.base_space = TrueBase();
  const tools::Headset headset{
      .runtime = "Omni test runtime '1.0-5-gabcdef1'", .system = "Omni test system", .space = protocol::kSpaceStage};
  const auto stored = tools::RequestBasePose(**connection, tools::StoreCommand(headset, outcome, "touch"));
  ASSERT_TRUE(stored.ok()) << stored.error();
}

// False recentrings reported by a faulty application only clear TRACKED, and a person can restore the alignment. The
// runtime has been updated in between.
TEST(ProcessAlign, FaultyApplicationOnlyMarksAlignmentDoubtful) {
  ServiceProcess service;
  service.Start();
  ASSERT_GT(service.pid(), 0);
  TestApplication application(service);
  ASSERT_TRUE(application.Focus());
  ASSERT_NO_FATAL_FAILURE(StoreInStage(service));
  auto base_pose = BasePoseOf(service, application);
  ASSERT_TRUE(base_pose);
  EXPECT_EQ(base_pose->known, 1U) << "of another build of the runtime";
  const auto taken = [&](std::uint32_t doubtful) {
    return application.Run(5000, 5, [&] {
      if (const auto newer = application.connection().PopBasePose()) base_pose = newer;
      return base_pose->doubtful == doubtful;
    });
  };
  for (int i = 0; i < 5; ++i) {
    protocol::SpaceChange change;
    change.space = protocol::kSpaceStage;
    change.pose_valid = 1;
    change.changes_at_ns = base::MonotonicNow_ns() + i * 2 * protocol::kSameChange_ns;
    change.new_in_previous.position_m = {20, 0, 0};
    ASSERT_TRUE(application.connection().Send(change));
  }
  EXPECT_TRUE(taken(1)) << "it hears that the alignment is in doubt";
  EXPECT_EQ(base_pose->base_space.position_m[0], TrueBase().position_m.x);
  const Outcome shown = OmniAlign(service, {"--show"});
  EXPECT_NE(shown.out.find("DOUBTFUL"), std::string::npos) << shown.out;
  const Outcome restored = OmniAlign(service, {"--restore"});
  EXPECT_EQ(restored.status, 0) << restored.err;
  EXPECT_TRUE(taken(0)) << "and that it is not any more";
  EXPECT_EQ(OmniAlign(service, {"--show"}).out.find("DOUBTFUL"), std::string::npos);
}

// The person does nothing: the command gives up in time, reports what is missing and stores nothing.
TEST(ProcessAlign, TimesOutWithHintAndStoresNothing) {
  const std::string build = OMNI_BINARY_DIR;
  setenv("XR_RUNTIME_JSON", (build + "/share/openxr/1/omni_test_runtime.json").c_str(), 1);
  unsetenv("OMNI_TEST_RUNTIME_SCRIPT");
  ServiceProcess service;
  service.Start();
  {
    TestApplication wait(service);
    ASSERT_TRUE(wait.Focus());
  }
  const std::string probe = build + "/bin/omni_align_probe";
  const Outcome still = OmniAlign(service, {"touch", "--hand", "left", "--probe", probe, "--patience", "6"});
  EXPECT_EQ(still.status, 1);
  EXPECT_NE(still.err.find("turned too little"), std::string::npos) << still.err;
  const Outcome nobody = OmniAlign(service, {"touch", "--hand", "right", "--probe", probe, "--patience", "5"});
  EXPECT_NE(nobody.err.find("switched on"), std::string::npos) << nobody.err;
  const Outcome fingers = OmniAlign(service, {"fingertip", "--probe", probe, "--patience", "5"});
  EXPECT_EQ(fingers.status, 1) << "this runtime has no hand tracking, or nobody's hands";
  EXPECT_NE(OmniAlign(service, {"--show"}).out.find("no alignment is stored"), std::string::npos);
}

}  // namespace test_process_align
}  // namespace omni::test
