// Pull a face out by a step, push it in by a step.
#include <gtest/gtest.h>

#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_haptics_extrude {

constexpr double kTop_m = 0.01;

// The top of a block can be extruded, the rest is rigid.
SceneInput ExtrudableBlock() {
  SceneInput input = SceneOf(Block(6, {0.02, 0.02, kTop_m}));
  Material clay;
  clay.extrude.enabled = true;
  input.materials.push_back(clay);
  InputObject& block = input.objects[0];
  for (std::size_t t = 0; t < block.triangles.size(); ++t) {
    bool on_top = true;
    for (const std::uint32_t v : block.triangles[t]) on_top = on_top && block.vertices_base_m[v].z == kTop_m;
    if (on_top) block.triangle_material[t] = 1;
  }
  return input;
}

// Moves and checks in every tick that the force neither steps nor exceeds the limit.
class Sculptor {
 public:
  Sculptor() : pen(Built(ExtrudableBlock())) { pen.MoveTo({0.001, 0.002, 0.03}); }

  void GoTo(double height_m, double speed_m_s) {
    const double from = pen.state.last_device_point_base_m.z, to = kTop_m + height_m;
    const int ticks = 1 + static_cast<int>(std::abs(to - from) / (speed_m_s * 1e-3));
    for (int k = 1; k <= ticks; ++k) Tick(from + (to - from) * k / ticks);
  }
  void Wait(int ticks) {
    const double z = pen.state.last_device_point_base_m.z;
    for (int k = 0; k < ticks; ++k) Tick(z);
  }
  void Press() {  // 1.6 mm at 400 N/m: 0.64 N
    GoTo(region().offset_m - 0.0016, 0.05);
    Wait(250);
  }
  const RegionState& region() const { return pen.state.regions[0]; }

  Pen pen;
  double strongest_pull_N = 0;

 private:
  void Tick(double z) {
    const Vec3 before = pen.output.force_base_N;
    pen.MoveTo({0.001, 0.002, z});
    EXPECT_LE(Norm(pen.output.force_base_N - before), 0.85 * 1.000001);
    EXPECT_LE(Norm(pen.output.force_base_N), 2);
    strongest_pull_N = std::max(strongest_pull_N, -pen.output.force_base_N.z);
  }
};

TEST(Extrude, ShortOrLightPressDoesNotGrabTheFace) {
  Sculptor s;
  s.GoTo(-0.0016, 0.05);
  s.Wait(100);
  EXPECT_EQ(s.region().phase, ExtrudePhase::kPressed);
  s.GoTo(0.003, 0.05);
  EXPECT_EQ(s.region().phase, ExtrudePhase::kFree);
  s.GoTo(-0.001, 0.05);
  s.Wait(500);
  EXPECT_EQ(s.region().phase, ExtrudePhase::kFree);
  EXPECT_EQ(s.region().offset_m, 0);
}

TEST(Extrude, PullingAHeldFaceMovesItOutOneStep) {
  Sculptor s;
  s.Press();
  EXPECT_EQ(s.region().phase, ExtrudePhase::kHeld);
  s.GoTo(0.006, 0.02);
  EXPECT_GT(s.strongest_pull_N, 0.2) << "the face resists";
  s.Wait(300);
  s.GoTo(0.015, 0.1);
  s.Wait(200);
  EXPECT_EQ(s.region().phase, ExtrudePhase::kFree);
  EXPECT_EQ(s.region().step, 1);
  EXPECT_EQ(s.region().edits, 1U);
  EXPECT_NEAR(s.region().offset_m, 0.004, 1e-12);
  // The new face is where it says, and so are its walls.
  s.GoTo(0.004 - 0.001, 0.02);
  EXPECT_EQ(s.pen.output.contact_count, 1);
  EXPECT_NEAR(s.pen.output.contacts[0].gap_m, -0.001, 1e-9);
}

TEST(Extrude, PushingAHeldFaceMovesItInOneStep) {
  Sculptor s;
  s.Press();
  s.GoTo(-0.0016 - 0.003, 0.02);
  s.Wait(400);
  EXPECT_EQ(s.region().step, -1);
  EXPECT_EQ(s.region().edits, 1U);
  EXPECT_NEAR(s.region().offset_m, -0.004, 1e-12);
  s.GoTo(0.01, 0.1);
  s.Wait(100);
  EXPECT_EQ(s.region().step, -1);
  s.GoTo(-0.0035, 0.02);
  EXPECT_EQ(s.pen.output.contact_count, 0) << "above the face that went in";
}

TEST(Extrude, OutThenInReturnsToZeroOffset) {
  Sculptor s;
  s.Press();
  s.GoTo(0.006, 0.02);
  s.Wait(300);
  s.GoTo(0.02, 0.1);
  s.Wait(200);
  ASSERT_EQ(s.region().step, 1);
  s.Press();
  ASSERT_EQ(s.region().phase, ExtrudePhase::kHeld);
  s.GoTo(0.004 - 0.0016 - 0.003, 0.02);
  s.Wait(400);
  EXPECT_EQ(s.region().step, 0);
  EXPECT_EQ(s.region().edits, 2U);
  EXPECT_EQ(s.region().offset_m, 0);
}

TEST(Extrude, TearingAwayReleases) {
  Sculptor s;
  s.Press();
  s.GoTo(0.03, 2);
  s.Wait(200);
  EXPECT_EQ(s.region().phase, ExtrudePhase::kFree);
  EXPECT_LE(s.region().offset_m, 0.004 + 1e-12);
}

TEST(Extrude, TrackingLossSettlesTheFaceOnAStep) {
  Sculptor s;
  s.Press();
  s.GoTo(0.0035, 0.03);
  ASSERT_EQ(s.region().phase, ExtrudePhase::kHeld);
  ASSERT_GT(s.region().offset_m, 0);
  for (int k = 0; k < 200; ++k) s.pen.Lose();
  EXPECT_EQ(s.region().phase, ExtrudePhase::kFree);
  EXPECT_NEAR(s.region().offset_m, s.region().step * 0.004, 1e-12);
}

// A face that rises under a still pen takes it along instead of passing it.
TEST(Extrude, RisingFacePushesAStillTip) {
  Sculptor s;
  s.GoTo(0.0015, 0.05);
  s.pen.state.regions[0].phase = ExtrudePhase::kSettling;
  s.pen.state.regions[0].offset_m = 0.0025;  // will settle at 4 mm, the tip is at 1.5: it starts inside
  s.pen.state.was_tracked = false;           // as after a long absence
  s.Wait(1);
  EXPECT_EQ(s.pen.output.contact_count, 1);

  Sculptor t;
  t.pen.state.regions[0].phase = ExtrudePhase::kSettling;
  t.pen.state.regions[0].offset_m = 0.0021;
  t.GoTo(0.003, 10);
  EXPECT_EQ(t.pen.output.contact_count, 0);
  t.Wait(100);
  EXPECT_NEAR(t.region().offset_m, 0.004, 1e-12);
  EXPECT_EQ(t.pen.output.contact_count, 1) << "swept over the tip";
  EXPECT_NEAR(t.pen.output.contacts[0].gap_m, -0.001, 1e-9);
}

}  // namespace test_haptics_extrude
}  // namespace omni::haptics
