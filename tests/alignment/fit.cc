// The joint fit: what it finds, what it rejects and with which words, which touch it calls wrong.
#include "service/alignment/fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "service/alignment/dwell.h"
#include "tests/support/rig/alignment_scenario.h"

namespace omni::alignment {
namespace test_alignment_fit {

using test::AlignmentScenario;

constexpr base::Vec3 kTip{0.01, -0.02, -0.1};
const std::vector<base::Vec3> kMarks{{0.0618, -0.0508, -0.07},
                                     {0.052, 0.0608, -0.07},
                                     {-0.0311, 0.0737, -0.07},
                                     {-0.079, -0.0126, -0.07},
                                     {0, 0, 0.0375}};

std::vector<Sample> Touches(AlignmentScenario& scenario, const Rigid& X_LB, double noise_m, std::size_t count = 5) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < count; ++i)
    samples.push_back(scenario.At(X_LB, kMarks[i], kTip, noise_m, static_cast<int>(i)));
  return samples;
}

Prior KnownTip(bool level = true) {
  Prior prior;
  prior.level = level;
  prior.tip_controller_m = kTip;
  prior.tip_sigma_m = 5e-4;
  return prior;
}

void ExpectHas(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << part << " not in: " << text;
}

TEST(AlignmentFit, NoiseFreeTouchesRecoverTheExactBasePose) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    AlignmentScenario scenario(seed);
    const bool level = seed % 2 == 0;
    const Rigid truth = level ? scenario.LevelBase() : scenario.AnyBase();
    const auto outcome = FitTouches(Touches(scenario, truth, 0), KnownTip(level), {});
    ASSERT_TRUE(outcome.ok()) << seed << ": " << outcome.error();
    EXPECT_LT(Distance_m(outcome->base_space, truth, kWorkingPoint_base_m), 1e-7) << seed;
    EXPECT_LT(Angle_rad(outcome->base_space, truth), 1e-6) << seed;
    EXPECT_LT(outcome->rms_m, 1e-7);
    EXPECT_EQ(outcome->wrong_group, -1);
    EXPECT_GT(outcome->expected_error_m, 1e-4) << "few touches that fit by chance are not exact";
  }
}

// A tip that has not been measured is found with the base when the controller turns.
TEST(AlignmentFit, UnknownTipIsFoundTogetherWithTheBase) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    AlignmentScenario scenario(seed);
    const Rigid truth = scenario.AnyBase();
    std::vector<Sample> samples;
    for (int i = 0; i < 120; ++i) samples.push_back(scenario.At(truth, scenario.PointOfBase(), kTip, 0, 0));
    Prior prior;
    prior.level = false;
    const auto outcome = FitBasePose(samples, prior, {});
    ASSERT_TRUE(outcome.ok()) << seed << ": " << outcome.error();
    EXPECT_LT(Distance_m(outcome->base_space, truth, kWorkingPoint_base_m), 1e-6) << seed;
    const base::Vec3& tip = outcome->tip_controller_m;
    EXPECT_LT(std::hypot(tip.x - kTip.x, tip.y - kTip.y, tip.z - kTip.z), 1e-6);
  }
}

TEST(AlignmentFit, TimeOffsetIsFound) {
  AlignmentScenario scenario(3);
  const Rigid truth = scenario.LevelBase();
  constexpr double kLate_s = 0.012;
  std::vector<Sample> samples;
  for (int i = 0; i < 200; ++i) {
    const base::Vec3 p = scenario.PointOfBase();
    const Eigen::Vector3d v = scenario.Normal(0.15);
    Sample sample = scenario.At(truth, p, kTip, 0, 0);
    // The controller shows what the pen showed kLate_s earlier.
    sample.point_base_m = base::FromEigen(Eigen::Vector3d(base::ToEigen(p) + kLate_s * v));
    sample.velocity_base_m_s = base::FromEigen(v);
    samples.push_back(sample);
  }
  Prior prior;
  prior.time_offset = true;
  const auto outcome = FitBasePose(samples, prior, {});
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_NEAR(outcome->time_offset_s, -kLate_s, 1e-3 * kLate_s);
  EXPECT_LT(Distance_m(outcome->base_space, truth, kWorkingPoint_base_m), 1e-5);
  prior.time_offset = false;
  const auto without = FitBasePose(samples, prior, {});
  ASSERT_TRUE(without.ok()) << without.error();
  EXPECT_GT(without->rms_m, 1e-3) << "the offset would be seen as noise";
}

TEST(AlignmentFit, OneWrongTouchOfFiveIsIdentified) {
  int named = 0, others = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    AlignmentScenario scenario(seed);
    const Rigid truth = scenario.LevelBase();
    std::vector<Sample> samples = Touches(scenario, truth, 1e-3);
    const int wrong = static_cast<int>(seed % 5);
    const Eigen::Vector3d by = scenario.Uniform(0.015, 0.06) * scenario.Normal(1).normalized();
    base::Vec3& p = samples[static_cast<std::size_t>(wrong)].controller_space.position_m;
    p = {p.x + by.x(), p.y + by.y(), p.z + by.z()};
    const auto outcome = FitTouches(samples, KnownTip(), {});
    if (!outcome.ok()) continue;
    EXPECT_EQ(outcome->groups, outcome->wrong_group < 0 ? 5 : 4);
    named += outcome->wrong_group == wrong;
    others += outcome->wrong_group >= 0 && outcome->wrong_group != wrong;
    if (outcome->wrong_group == wrong) {
      EXPECT_LT(Distance_m(outcome->base_space, truth, kWorkingPoint_base_m), 5e-3) << seed;
      EXPECT_NEAR(outcome->wrong_by_m, by.norm(), 0.01) << seed;
    }
  }
  EXPECT_GE(named, 170) << "of 200";
  EXPECT_LE(others, 4);
}

TEST(AlignmentFit, GoodTouchesAreNotFlaggedAsWrong) {
  int wrong = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    AlignmentScenario scenario(seed);
    const auto outcome = FitTouches(Touches(scenario, scenario.LevelBase(), 1.5e-3), KnownTip(), {});
    ASSERT_TRUE(outcome.ok()) << seed << ": " << outcome.error();
    wrong += outcome->wrong_group >= 0;
  }
  EXPECT_LE(wrong, 3);
}

TEST(AlignmentFit, TouchesInTheWrongOrderAreRejected) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    AlignmentScenario scenario(seed);
    std::vector<Sample> samples = Touches(scenario, scenario.LevelBase(), 1e-3);
    std::rotate(samples.begin(), samples.begin() + 1, samples.begin() + 4);  // the ring, one too far
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i].point_base_m = kMarks[i];
    const auto outcome = FitTouches(samples, KnownTip(), {});
    ASSERT_FALSE(outcome.ok()) << seed;
    ExpectHas(outcome.error(), "order");
  }
}

TEST(AlignmentFit, DegenerateDataIsRefusedWithARemedy) {
  AlignmentScenario scenario(1);
  const Rigid truth = scenario.LevelBase();
  const auto refusal = [&](const std::vector<base::Vec3>& points, const Limits& limits) {
    std::vector<Sample> samples;
    for (const base::Vec3& p : points)
      samples.push_back(scenario.At(truth, p, kTip, 1e-4, static_cast<int>(samples.size())));
    const auto outcome = FitBasePose(samples, KnownTip(), limits);
    return outcome.ok() ? "accepted" : outcome.error();
  };
  ExpectHas(refusal({{0.05, 0, 0}, {0, 0.05, 0}}, {}), "at least 3");
  ExpectHas(refusal({{0, 0, 0}, {0.04, 0, 0}, {0.08, 0, 1e-4}}, {}), "on a line; take one beside it");
  ExpectHas(refusal({{0, 0, 0}, {2e-3, 0, 0}, {0, 2e-3, 0}}, {}), "take them further apart");
  Limits volume;
  volume.plane_ratio_min = 0.05;
  ExpectHas(refusal({{0.05, 0, 0}, {-0.05, 0, 0}, {0, 0.05, 0}, {0, -0.05, 0}}, volume), "move up and down");
  ExpectHas(refusal({{0.05, 0, 0}, {0, 0.05, std::nan("")}, {0, 0, 0.05}}, {}), "not a valid pose");

  Prior unknown;
  std::vector<Sample> unturned;
  for (int i = 0; i < 80; ++i) {
    Sample sample = scenario.At(truth, scenario.PointOfBase(), {}, 1e-3, 0);
    sample.controller_space.orientation = {};
    unturned.push_back(sample);
  }
  const auto outcome = FitBasePose(unturned, unknown, {});
  ASSERT_FALSE(outcome.ok());
  ExpectHas(outcome.error(), "turn it about two axes");
}

// Pivot: the tip of a swung controller; refused when it was not swung, or slipped.
TEST(AlignmentPivot, FindsTheTip) {
  AlignmentScenario scenario(2);
  std::vector<Rigid> poses;
  for (int i = 0; i < 200; ++i) poses.push_back(scenario.At({}, {0.1, 0.2, 0.3}, kTip, 1e-3, 0).controller_space);
  const auto pivot = SolvePivot(poses);
  ASSERT_TRUE(pivot.ok()) << pivot.error();
  const base::Vec3& tip = pivot->tip_controller_m;
  EXPECT_LT(std::hypot(tip.x - kTip.x, tip.y - kTip.y, tip.z - kTip.z), 4 * pivot->tip_sigma_m);
  EXPECT_NEAR(pivot->rms_m, std::sqrt(3.0) * 1e-3, 3e-4);
  EXPECT_LT(std::hypot(pivot->centre_space_m.x - 0.1, pivot->centre_space_m.y - 0.2, pivot->centre_space_m.z - 0.3),
            1e-3);
}

TEST(AlignmentPivot, RejectsUninformativePoses) {
  AlignmentScenario scenario(5);
  std::vector<Rigid> still(100, scenario.At({}, {}, kTip, 0, 0).controller_space);
  ExpectHas(SolvePivot(still).error(), "turned too little");
  std::vector<Rigid> about_one_axis;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.02 * i, Eigen::Vector3d::UnitX()));
    about_one_axis.push_back({.orientation = base::FromEigen(q),
                              .position_m = base::FromEigen(Eigen::Vector3d(-(q * base::ToEigen(kTip))))});
  }
  ExpectHas(SolvePivot(about_one_axis).error(), "about one axis only");
  ExpectHas(SolvePivot({{}}).error(), "at least 20");
  std::vector<Rigid> slipping;
  for (int i = 0; i < 100; ++i) slipping.push_back(scenario.At({}, {1e-3 * i, 0, 0}, kTip, 0, 0).controller_space);
  ExpectHas(SolvePivot(slipping).error(), "press it into the dimple");
}

TEST(AlignmentDwell, DetectsRestsButNotMotion) {
  DwellDetector dwell;
  std::vector<base::Vec3> rests;
  double t = 0;
  const auto run = [&](double seconds, auto place) {
    for (const double end = t + seconds; t < end; t += 0.011) {
      if (const auto rest = dwell.Add(t, place(t))) rests.push_back(*rest);
    }
  };
  run(2, [](double at) { return base::Vec3{0.05 * at, 0, 0}; });
  EXPECT_TRUE(rests.empty()) << "5 cm/s is no rest";
  run(1.5, [](double) { return base::Vec3{0.1, 0, 0}; });
  ASSERT_EQ(rests.size(), 1U) << "one rest is one touch, however long it lasts";
  EXPECT_NEAR(rests[0].x, 0.1, 1e-3);
  run(0.3, [](double) { return base::Vec3{0.3, 0, 0}; });
  EXPECT_EQ(rests.size(), 1U) << "too short";
  run(1, [](double) { return base::Vec3{0.2, 0, 0}; });
  EXPECT_EQ(rests.size(), 2U);
}

}  // namespace test_alignment_fit
}  // namespace omni::alignment
