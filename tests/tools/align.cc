// `omni align` without a headset: probe output, keys, and results of simulated people.
#include <gtest/gtest.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "service/alignment/rigid.h"
#include "service/tools/align/align.h"
#include "service/tools/common/row_table.h"
#include "tests/support/rig/align_simulation.h"

namespace omni::tools {
namespace test_tools_align {

void ExpectSays(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " not in: " << text;
}

TEST(ToolsAlignProbe, ParsesValidLinesAndRejectsOthers) {
  const auto pose = ParseProbeLine("pose 123456789 right_finger 0.1 -2 3e-1 0 0 0.6 0.8");
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->says, ProbeSays::kPose);
  EXPECT_EQ(pose->text, "right_finger");
  EXPECT_EQ(pose->t_ns, 123456789);
  EXPECT_EQ(pose->pose.position_m, (base::Vec3{0.1, -2, 0.3}));
  EXPECT_NEAR(pose->pose.orientation.w, 0.8, 1e-12);
  EXPECT_NEAR(pose->pose.orientation.z, 0.6, 1e-12);
  EXPECT_EQ(ParseProbeLine("runtime Some Runtime 1.0")->text, "Some Runtime 1.0");
  EXPECT_EQ(ParseProbeLine("system \x1b[31mHMD")->text, "?[31mHMD") << "no control characters on a terminal";
  EXPECT_EQ(ParseProbeLine("space 3")->space, 3);
  EXPECT_EQ(ParseProbeLine("moved")->says, ProbeSays::kMoved);
  EXPECT_EQ(ParseProbeLine("end why")->text, "why");
  for (const char* line : {"", "pose", "pose 1 left 0 0 0 0 0 0", "pose 1 left 0 0 0 0 0 0 0",
                           "pose x left 0 0 0 0 0 0 1", "pose 1 left nan 0 0 0 0 0 1", "pose 1 left 1e9 0 0 0 0 0 1",
                           "space -1", "space x", "hello", "WARNING: some library"}) {
    EXPECT_FALSE(ParseProbeLine(line)) << line;
  }
}

TEST(ToolsAlignProbe, MissingProbeProgramIsNamedInError) {
  const auto probe = AlignProbe::Start("/no/such/probe", {});
  ASSERT_FALSE(probe.ok());
  ExpectSays(probe.error(), {"/no/such/probe", "--probe"});
}

TEST(ToolsAlignProbe, ReportsEndWhenChildExits) {
  const auto probe = AlignProbe::Start("/bin/true", {});
  ASSERT_TRUE(probe.ok()) << probe.error();
  const auto line = (*probe)->NextLine(5000);
  ASSERT_TRUE(line);
  EXPECT_EQ(line->says, ProbeSays::kEnd);
}

// Keys move along the axes of the base, whichever way it faces in the space.
TEST(ToolsAlignNudge, KeysMoveAndTurnAndUndo) {
  const alignment::Rigid start = alignment::NudgedPose(alignment::LevelBase(), 0.7, {1, 2, 3});
  const auto moved = [&](const std::string& keys) {
    Nudge nudge(start);
    for (const char key : keys) nudge.HandleKey(key);
    return alignment::Compose(alignment::Inverse(start), nudge.base_pose());
  };
  const auto expect = [](const alignment::Rigid& X, base::Vec3 p) {
    EXPECT_NEAR(X.position_m.x, p.x, 1e-12);
    EXPECT_NEAR(X.position_m.y, p.y, 1e-12);
    EXPECT_NEAR(X.position_m.z, p.z, 1e-12);
  };
  expect(moved("\033[C"), {5e-3, 0, 0});
  expect(moved("\033[A\033[A"), {0, 10e-3, 0});
  expect(moved("\033[5~"), {0, 0, 5e-3});
  expect(moved("a"), {-5e-3, 0, 0});
  expect(moved("--d"), {1.25e-3, 0, 0});
  expect(moved("+s"), {0, -10e-3, 0});
  expect(moved("dwr[u"), {0, 0, 0});
  expect(moved("xyz \033\033[Z"), {0, 0, 0});
  const alignment::Rigid turned = moved("[");
  EXPECT_NEAR(2 * turned.orientation.z, 8.75e-3, 1e-6) << "about the base's z, half a degree";
  Nudge nudge(start);
  EXPECT_EQ(nudge.HandleKey('q'), Nudge::Does::kDone);
}

TEST(ToolsAlignService, ChoosesAlignmentByNumberOrConnectedHeadset) {
  const auto row = [](const char* runtime, double x) {
    return nlohmann::json{{"runtime", runtime},
                          {"system", "s"},
                          {"space", 3},
                          {"samples", 5},
                          {"rms_mm", 1.5},
                          {"position_space_m", {x, 0, 0}},
                          {"orientation_space_wxyz", {1, 0, 0, 0}}};
  };
  nlohmann::json status{{"clients", nlohmann::json::array()}, {"alignments", {{"stored", {row("a", 1), row("b", 2)}}}}};
  EXPECT_FALSE(ChooseAlignment(status, 0).ok()) << "two, and no application says which";
  EXPECT_EQ(ChooseAlignment(status, 2)->headset.runtime, "b");
  EXPECT_FALSE(ChooseAlignment(status, 3).ok());
  status["clients"].push_back({{"runtime", "b"}, {"system", "s"}});
  EXPECT_EQ(ChooseAlignment(status, 0)->base_space.position_m.x, 2);
  status["clients"][0]["runtime"] = "c";
  const auto guess = ChooseAlignment(status, 0);
  ASSERT_TRUE(guess.ok());
  EXPECT_EQ(guess->headset.runtime, "c");
  EXPECT_EQ(guess->base_space.position_m.z, -0.45) << "where the layer guesses it";
  ExpectSays(StoredAlignmentsText(status), {"1  a / s in STAGE", "2  b / s"});
  status["alignments"]["stored"][1]["runtime"] = "c 'v1.0-5-g1234567'";
  status["clients"][0]["runtime"] = "c 'v1.1'";
  EXPECT_EQ(ChooseAlignment(status, 0)->base_space.position_m.x, 2) << "another build of the same runtime";
  status["alignments"]["stored"][0].update(
      {{"expected_error_mm", 1.0}, {"starts", 3}, {"error_now_mm", 12.2}, {"drifted", true}});
  ExpectSays(StoredAlignmentsText(status), {"12.2 mm by now, after 3 starts", "--check --correct"});
  status["alignments"]["stored"][1].update({{"recentred", 2}, {"moved_m", 1.25}, {"doubtful", true}});
  ExpectSays(StoredAlignmentsText(status),
             {"adjusted for 2 recentrings, 1.25 m from where it was measured", "--restore"});
}

AlignOptions With(AlignMethod method) {
  AlignOptions options;
  options.method = method;
  return options;
}

// Every method finishes in time, close to the truth, and predicts its error.
TEST(ToolsAlignSession, EachMethodFindsBaseWithinPredictedError) {
  struct Case {
    AlignMethod method;
    double most_m;
  };
  for (const Case& what :
       {Case{AlignMethod::kTouch, 9e-3}, Case{AlignMethod::kSweep, 6e-3}, Case{AlignMethod::kFingertip, 30e-3}}) {
    double squares = 0, predicted = 0;
    std::vector<double> seconds;
    int refused = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const test::AlignTrial trial = test::SimulateAlignment(With(what.method), {}, seed);
      refused += trial.refused;
      if (trial.refused) continue;
      EXPECT_LT(trial.error_m, what.most_m) << AlignMethodName(what.method) << " " << seed;
      seconds.push_back(trial.seconds);
      squares += trial.error_m * trial.error_m;
      predicted += trial.outcome.expected_error_m * trial.outcome.expected_error_m;
    }
    EXPECT_LE(refused, 2) << AlignMethodName(what.method);
    EXPECT_LT(Quantile(seconds, 0.5), 20) << AlignMethodName(what.method);
    EXPECT_LT(Quantile(seconds, 0.9), 30) << AlignMethodName(what.method);
    const double ratio = std::sqrt(squares / predicted);
    EXPECT_GT(ratio, 0.5) << AlignMethodName(what.method);
    EXPECT_LT(ratio, 1.5) << AlignMethodName(what.method);
  }
}

// One touch, some seconds: near enough to see what 10 mm are.
TEST(ToolsAlignSession, CheckFindsTheFirstMark) {
  std::vector<double> errors_m, seconds;
  for (std::uint64_t seed = 100; seed < 160; ++seed) {
    const test::AlignTrial trial = test::SimulateAlignment(With(AlignMethod::kCheck), {}, seed);
    ASSERT_FALSE(trial.refused) << seed << ": " << trial.problem;
    errors_m.push_back(trial.error_m);
    seconds.push_back(trial.seconds);
  }
  std::printf("[ figure   ] simulated: mark 1 within %.1f mm (median), %.1f mm (9 of 10), after %.1f s (median)\n",
              1e3 * Quantile(errors_m, 0.5), 1e3 * Quantile(errors_m, 0.9), Quantile(seconds, 0.5));
  EXPECT_LT(Quantile(errors_m, 0.9), 3.5e-3);
  EXPECT_LT(Quantile(seconds, 0.5), 7);
}

TEST(ToolsAlignService, BaseFollowsItsTouchedMark) {
  const alignment::Rigid stored = alignment::NudgedPose(alignment::LevelBase(), 0.7, {1, 2, 3});
  const base::Vec3 mark_m{0.05, -0.02, 0.01}, off_m{4e-3, -1e-3, 2e-3};
  const alignment::Rigid moved = BaseAsTouched(stored, mark_m, alignment::TransformPoint(stored, mark_m) + off_m);
  EXPECT_NEAR(
      base::Distance(alignment::TransformPoint(moved, mark_m), alignment::TransformPoint(stored, mark_m) + off_m), 0,
      1e-12);
  EXPECT_EQ(alignment::Angle_rad(moved, stored), 0);
}

TEST(ToolsAlignService, CheckWantsAnAlignmentOfItsHeadsetAndSpace) {
  const nlohmann::json row{{"runtime", "Monado(XRT) 'v25.1.0'"},
                           {"system", "s"},
                           {"space", 3},
                           {"position_space_m", {1, 0, 0}},
                           {"orientation_space_wxyz", {1, 0, 0, 0}}};
  const nlohmann::json status{{"alignments", {{"stored", {row}}}}};
  EXPECT_TRUE(AlignmentOf(status, {.runtime = "Monado(XRT) 'v25.2'", .system = "s", .space = 3}).ok());
  EXPECT_FALSE(AlignmentOf(status, {.runtime = "Monado(XRT)", .system = "s", .space = 2}).ok());
  EXPECT_FALSE(AlignmentOf(status, {.runtime = "SteamVR", .system = "s", .space = 3}).ok());
}

TEST(ToolsAlignSession, IsDeterministicForEqualSeeds) {
  const test::AlignTrial a = test::SimulateAlignment(With(AlignMethod::kTouch), {}, 5);
  const test::AlignTrial b = test::SimulateAlignment(With(AlignMethod::kTouch), {}, 5);
  EXPECT_EQ(a.error_m, b.error_m);
  EXPECT_EQ(a.outcome.base_space.position_m, b.outcome.base_space.position_m);
}

TEST(ToolsAlignSession, NamesWronglyTouchedMark) {
  test::AlignNoise noise;
  noise.wrong_touch = 1;
  int named = 0, other = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const test::AlignTrial trial = test::SimulateAlignment(With(AlignMethod::kTouch), noise, seed);
    if (trial.refused) continue;
    named += trial.outcome.wrong_group == trial.wrong_touch;
    other += trial.outcome.wrong_group >= 0 && trial.outcome.wrong_group != trial.wrong_touch;
    if (trial.outcome.wrong_group == trial.wrong_touch) {
      ExpectSays(AlignOutcomeText(With(AlignMethod::kTouch), trial.outcome), {"left out", "touch it again"});
    }
  }
  EXPECT_GE(named, 28) << "of 40";
  EXPECT_LE(other, 3);
}

TEST(ToolsAlignSession, SweepHintsWhenPenIsNotTracked) {
  AlignSession session(With(AlignMethod::kSweep));
  for (int i = 0; i < 1000; ++i) session.Add(0.01 * i, {}, std::nullopt);
  EXPECT_EQ(session.step(), AlignStep::kSweep);
  ExpectSays(session.hint(), {"the pen is not tracked"});
}

TEST(ToolsAlignSession, TouchStaysInPivotStepUntilControllerIsSwung) {
  AlignSession session(With(AlignMethod::kTouch));
  for (int i = 0; i < 2000; ++i) session.Add(0.011 * i, {}, std::nullopt);
  EXPECT_EQ(session.step(), AlignStep::kPivot);
  ExpectSays(session.hint(), {"swing"});
}

TEST(ToolsAlignText, QualityWordFollowsErrorAndNanIsPoor) {
  EXPECT_EQ(AlignQualityWord(0.8e-3), "excellent");
  EXPECT_EQ(AlignQualityWord(1.5e-3), "good");
  EXPECT_EQ(AlignQualityWord(3e-3), "fair");
  EXPECT_EQ(AlignQualityWord(5e-3), "poor");
  EXPECT_EQ(AlignQualityWord(std::nan("")), "poor");
}

}  // namespace test_tools_align
}  // namespace omni::tools
