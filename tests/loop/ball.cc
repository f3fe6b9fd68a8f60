// A ball tip in the whole loop against the twin: a hand leads the pen around the upper edges of a cube.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "service/haptics/scene/scene.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_loop_ball {

constexpr double kHalf_m = 0.012, kMiddle_m = 0.050;  // of a cube of 24 mm
constexpr double kStart_s = 0.8, kEdge_s = 0.7;
constexpr int kEdges = 28;
constexpr double kTip_m = 0.0005;

haptics::Scene CubeForABall() {
  haptics::SceneInput input;
  input.name = "cube";
  haptics::Material& slippery = input.materials.emplace_back();  // friction may well point inwards at an edge
  slippery.static_friction = slippery.dynamic_friction = 0;
  input.objects.push_back(Box({0, 0, kMiddle_m}, {kHalf_m, kHalf_m, kHalf_m}, 1));
  input.tip_radius_m = kTip_m;
  haptics::BuildReport report;
  return std::move(haptics::BuildScene(input, report).value());
}

// From over the cube down, and around its four upper edges; the pen aims this far inside of its sides and its top.
sim::HandScript AroundTheUpperEdges(double inset_m, double down_m) {
  sim::HandScript script;
  script.name = "around the upper edges";
  script.stiffness_N_m = 150;
  const double top_m = kMiddle_m + kHalf_m, rim_m = kHalf_m - inset_m;
  script.waypoints = {{.duration_s = 0, .tip_base_m = {rim_m, -rim_m, top_m + 0.012}},
                      {.duration_s = kStart_s, .tip_base_m = {rim_m, -rim_m, top_m + 0.004}}};
  constexpr double kCorners[4][2] = {{1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
  for (int k = 0; k < kEdges; ++k) {
    const auto& [x, y] = kCorners[k % 4];
    script.waypoints.push_back({.duration_s = kEdge_s, .tip_base_m = {rim_m * x, rim_m * y, top_m - down_m}});
  }
  return script;
}

// How far the force pushes towards the inside at the nearest of the faces; 0 outside.
double Inwards_N(const base::Vec3& tip, const base::Vec3& force_N) {
  const double depth_m[] = {kHalf_m - std::abs(tip.x), kHalf_m - std::abs(tip.y),
                            kHalf_m - std::abs(tip.z - kMiddle_m)};
  const double out_N[] = {std::copysign(1, tip.x) * force_N.x, std::copysign(1, tip.y) * force_N.y,
                          std::copysign(1, tip.z - kMiddle_m) * force_N.z};
  const int nearest = depth_m[0] < depth_m[1] ? (depth_m[0] < depth_m[2] ? 0 : 2) : (depth_m[1] < depth_m[2] ? 1 : 2);
  return depth_m[nearest] > 0 ? std::max(0.0, -out_N[nearest]) : 0;
}

bool IsInCube(const base::Vec3& p) {
  return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z - kMiddle_m)}) < kHalf_m;
}

// The ball's centre; without a contact that is the tip.
base::Vec3 CentreOf(const haptics::State& state) {
  const haptics::ContactState& contact = state.contacts[0];
  return contact.active ? contact.held_m : state.last_device_point_base_m;
}

// On the rim itself the ball has to roll most; far inside, the tip comes near to faces that it did not come through.
TEST(LoopBall, TipLedAroundEdgesIsNeverPushedDeeper) {
  const haptics::Scene cube = CubeForABall();
  for (const auto& [inset_m, down_m] : {std::pair{0.0, 0.001}, {0.001, 0.005}}) {
    const std::uint64_t seed = inset_m > 0 ? 5 : 1;
    Scenario scenario(AroundTheUpperEdges(inset_m, down_m), kStart_s + kEdges * kEdge_s, seed);
    double worst_N = 0;
    int felt_ms = 0, inside_ms = 0, run_ms = 0, longest_ms = 0;
    while (scenario.Step(cube)) {
      const base::ToolState& tool = scenario.output.tool;
      const base::Vec3 centre = tool.device_point_base_m - kTip_m * tool.axis_base;
      const double inwards_N = Inwards_N(centre, scenario.output.wrench.force_N);
      worst_N = std::max(worst_N, inwards_N);
      run_ms = inwards_N > 0.02 ? run_ms + 1 : 0;
      longest_ms = std::max(longest_ms, run_ms);
      felt_ms += scenario.force_N() > 0.05 ? 1 : 0;
      inside_ms += IsInCube(CentreOf(scenario.state.haptics)) ? 1 : 0;
    }
    EXPECT_GT(felt_ms, 2500);
    EXPECT_EQ(inside_ms, 0) << inset_m;
    EXPECT_EQ(longest_ms, 0) << inset_m << ", with up to " << worst_N << " N";
  }
}

}  // namespace test_loop_ball
}  // namespace omni::test
