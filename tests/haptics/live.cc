// Which objects get a sculpt session or a soft body, why not, and how tags become parameters.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/sculpt_query.h"
#include "service/haptics/sculpt/sculpted_scene.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics {
namespace test_haptics_live {

Material Clay() {
  Material clay;
  clay.sculpt.enabled = true;
  return clay;
}

Material Jelly() {
  Material jelly;
  jelly.softness.model = SoftnessModel::kTet;
  return jelly;
}

InputObject OneSide(InputObject object) {
  object.triangles.resize(object.triangles.size() / 6);
  object.triangle_material.resize(object.triangles.size());
  return object;
}

bool Says(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

TEST(LivePlanTest, UntaggedOrNonCollidableObjectsPlanNothing) {
  EXPECT_TRUE(PlanLive(Scene()).empty());
  const LivePlan plan = PlanLive(Built(SceneOf(Sphere(6, 0.02))));
  EXPECT_TRUE(plan.empty());
  EXPECT_TRUE(plan.lines.empty());
  InputObject seen = Sphere(6, 0.02);
  seen.collidable = false;
  EXPECT_TRUE(PlanLive(Built(SceneOf(seen, Clay()))).empty());
}

TEST(LivePlanTest, OnlyClosedSingleSidedClayIsSculpted) {
  EXPECT_EQ(PlanLive(Built(SceneOf(Sphere(6, 0.02), Clay()))).sculpted, std::vector<std::uint32_t>{0});
  LivePlan plan = PlanLive(Built(SceneOf(OneSide(Sphere(6, 0.02)), Clay())));
  EXPECT_TRUE(plan.empty());
  EXPECT_TRUE(Says(plan.lines, "not closed")) << plan.lines.size();
  InputObject thin = Sphere(6, 0.02);
  thin.double_sided = true;
  plan = PlanLive(Built(SceneOf(thin, Clay())));
  EXPECT_TRUE(plan.empty());
  EXPECT_TRUE(Says(plan.lines, "double-sided"));
}

TEST(LivePlanTest, SculptableObjectsBeyondFourStayRigid) {
  SceneInput input = SceneOf(Sphere(4, 0.01), Clay());
  for (int k = 1; k < 6; ++k) {
    input.objects.push_back(Sphere(4, 0.01));
    for (Vec3& v : input.objects.back().vertices_base_m) v.x += 0.03 * k;
  }
  const LivePlan plan = PlanLive(Built(input));
  EXPECT_EQ(plan.sculpted, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(plan.lines.size(), 2U);
  EXPECT_TRUE(Says(plan.lines, "at most 4"));
}

TEST(LivePlanTest, TetObjectsAreSoftEvenWhenOpen) {
  EXPECT_EQ(PlanLive(Built(SceneOf(Sphere(6, 0.02), Jelly()))).soft, std::vector<std::uint32_t>{0});
  EXPECT_EQ(PlanLive(Built(SceneOf(OneSide(Sphere(6, 0.02)), Jelly()))).soft, std::vector<std::uint32_t>{0});
  Material layer = Jelly();
  layer.softness.model = SoftnessModel::kWinkler;
  EXPECT_TRUE(PlanLive(Built(SceneOf(Sphere(6, 0.02), layer))).empty());
}

TEST(LivePlanTest, TheMaterialOfMostTrianglesDecides) {
  SceneInput input = SceneOf(Sphere(6, 0.02), Clay());
  input.materials.push_back(Jelly());
  auto& material = input.objects[0].triangle_material;
  for (std::size_t t = 0; t < material.size(); ++t) material[t] = t % 5 < 3;
  const LivePlan plan = PlanLive(Built(input));
  EXPECT_TRUE(plan.sculpted.empty());
  EXPECT_EQ(plan.soft, std::vector<std::uint32_t>{0});
}

TEST(LivePlanTest, ExtrudableObjectsAreNeitherSculptedNorSoft) {
  for (const Material& material : {Clay(), Jelly()}) {
    SceneInput input = SceneOf(Block(6, {0.02, 0.02, 0.02}), material);
    input.materials.push_back({});
    input.materials[1].extrude.enabled = true;
    for (std::size_t t = 0; t < 72; ++t) input.objects[0].triangle_material[t] = 1;  // one side
    const LivePlan plan = PlanLive(Built(input));
    EXPECT_TRUE(plan.empty());
    EXPECT_TRUE(Says(plan.lines, "extruded"));
  }
}

// Property over bodies of several sizes and places: the mesh that a sculpt session gets is the one that is touched.
TEST(LiveMeshTest, MeshOfMatchesTheObjectInTheScene) {
  for (int n : {3, 7, 16}) {
    SceneInput input = SceneOf(Sphere(5, 0.01), Material());
    input.materials.push_back(Clay());
    InputObject ball = sculpt::BumpyBall(n, 0.02);
    for (Vec3& v : ball.vertices_base_m) v.x += 0.05;
    for (std::size_t t = 0; t < ball.triangle_material.size(); ++t) ball.triangle_material[t] = t % 4 != 0;
    input.objects.push_back(ball);
    const Scene scene = Built(input);
    const Mesh mesh = MeshOf(scene, 1);
    const Object& object = scene.objects()[1];
    ASSERT_EQ(mesh.triangles.size(), object.triangle_count);
    EXPECT_EQ(2 * mesh.vertices.size(), mesh.triangles.size() + 4) << "Euler: a closed ball";
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& of = scene.triangles()[object.first_triangle + t];
      EXPECT_EQ(mesh.material[t], of.material);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vertex& v = scene.vertices()[of.vertex[k]];
        EXPECT_EQ(mesh.vertices[mesh.triangles[t][k]], (Vec3{v.x, v.y, v.z}));
        const auto& across = mesh.triangles[mesh.neighbours[t][k]];
        const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
        EXPECT_NE(std::find(across.begin(), across.end(), a), across.end());
        EXPECT_NE(std::find(across.begin(), across.end(), b), across.end());
      }
    }
  }
}

TEST(LiveSculptSessionTest, TakesSurfaceAndParametersFromTheScene) {
  SceneInput input = SceneOf(Sphere(5, 0.01), Material());
  Material clay = Clay();
  clay.stiffness_N_m = 333;
  clay.sculpt.snap_m = 0.002;
  clay.sculpt.symmetry = Symmetry::kY;
  clay.sculpt.falloff = Falloff::kLinear;
  clay.sculpt.radius_m = 0.004;
  input.materials.push_back(clay);
  InputObject ball = Sphere(10, 0.02);
  ball.name = "lump";
  for (Vec3& v : ball.vertices_base_m) v = v + Vec3{0.05, 0.07, 0.01};
  std::fill(ball.triangle_material.begin(), ball.triangle_material.end(), 1);
  input.objects.push_back(ball);
  const Scene scene = Built(input);
  LiveParts live;
  std::vector<std::string> lines;
  AddSculptSessions(scene, PlanLive(scene), live, lines);
  EXPECT_TRUE(lines.empty());
  ASSERT_EQ(live.sculpt_session_count(), 1U);
  EXPECT_EQ(live.object_at(0), 1U);
  sculpt::SculptSession& sculpt_session = live.sculpt_session_at(0);
  EXPECT_EQ(live.sculpt_session(1), &sculpt_session);
  EXPECT_EQ(live.sculpt_session(0), nullptr);
  EXPECT_EQ(sculpt_session.parameters().stiffness_N_m, 333);
  EXPECT_EQ(sculpt_session.parameters().grid_step_m, 0.002);
  EXPECT_EQ(sculpt_session.editor().options().grid_step_m, 0.002);
  EXPECT_EQ(sculpt_session.brush().falloff, sculpt::Falloff::kLinear);
  EXPECT_EQ(sculpt_session.brush().radius_m, 0.004);
  EXPECT_TRUE(sculpt_session.brush().symmetry.enabled);
  EXPECT_EQ(sculpt_session.brush().symmetry.normal, (Vec3{0, 1, 0}));
  EXPECT_LT(Norm(sculpt_session.brush().symmetry.point_base_m - Vec3{0.05, 0.07, 0.01}), 1e-12);
  const sculpt::SculptTable* table = sculpt_session.Acquire();
  ASSERT_NE(table, nullptr) << "the tick always finds a surface";
  const sculpt::SculptSurface surface(*table);
  const NearestResult top = NearestInTree(surface, 0, {0.05, 0.07, 0.05});
  ASSERT_NE(top.triangle, kNoIndex);
  EXPECT_EQ(surface.GetTriangle(top.triangle).object, 1);
  EXPECT_EQ(surface.GetTriangle(top.triangle).material, 1);

  const SceneInput saved = sculpt::SculptedScene(scene, live);
  ASSERT_EQ(saved.objects.size(), 1U);
  EXPECT_EQ(saved.objects[0].name, "lump");
  EXPECT_EQ(saved.objects[0].triangles.size(), scene.objects()[1].triangle_count);
  ASSERT_EQ(saved.materials.size(), 1U) << "the other object's material is not saved";
  EXPECT_EQ(saved.materials[0].stiffness_N_m, 333);
  const Scene again = Built(saved);
  ASSERT_FALSE(again.empty());
  EXPECT_EQ(PlanLive(again).sculpted, std::vector<std::uint32_t>{0}) << "what is saved can be sculpted on";
}

TEST(LiveSculptParametersTest, ParametersStayInRangeForRandomTags) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    Material m = Clay();
    m.stiffness_N_m = random.Uniform(0, 2000);
    m.sculpt.resistance_N_m = k == 0 ? 0 : k == 1 ? 2000 : random.Uniform(0, 2000);
    const sculpt::SculptParameters feel = SculptParametersOf(m);
    EXPECT_TRUE(feel.yield_N > 0 && feel.yield_N <= 2);
    EXPECT_TRUE(feel.hardening_N_m >= 0 && feel.hardening_N_m <= 2000);
    EXPECT_TRUE(feel.viscosity_Ns_m > 0 && feel.viscosity_Ns_m <= 100);
  }
}

// A hand that pulls: the force grows by the resistance for every metre the surface came along. docs/theory/sculpting.md
// (5.2)
TEST(LiveSculptParametersTest, ResistanceIsForcePerDisplacement) {
  for (const double resistance_N_m : {50.0, 200.0, 600.0}) {
    Material m = Clay();
    m.stiffness_N_m = 800;
    m.sculpt.resistance_N_m = resistance_N_m;
    const sculpt::SculptParameters feel = SculptParametersOf(m);
    sculpt::StrokeRing ring;
    sculpt::SculptToolState state;
    sculpt::SculptInput input;
    input.tracked = true;
    input.dt_s = 1e-3;
    input.stiffness_limit_N_m = input.normal_stiffness_limit_N_m = 2000;
    input.touch = {true, 0, {}, {}, {0, 0, 1}, 0.6};  // pressed
    std::map<double, double> pull_N;                  // by offset
    for (int k = 0; k < 600; ++k) {
      const bool pulls = k > 300;
      if (pulls) input.tip_base_m.z += 2e-5;
      const Vec3 force_N = StepSculptTool(feel, input, state, ring).force_N;
      for (sculpt::StrokeMessage message; ring.TryPop(message);) {
      }
      if (state.phase != sculpt::SculptPhase::kHeld || -force_N.z > 0.95 * feel.hold_force_max_N) continue;
      if (state.offset_m > 0) pull_N[state.offset_m] = -force_N.z;
    }
    ASSERT_GT(pull_N.size(), 20U) << resistance_N_m;
    const auto high = std::prev(pull_N.end()), low = pull_N.lower_bound(high->first / 2);
    const double slope_N_m = (high->second - low->second) / (high->first - low->first);
    EXPECT_NEAR(slope_N_m / resistance_N_m, 1, 0.1) << resistance_N_m;
    EXPECT_GT(low->second, feel.yield_N);
  }
}

TEST(LiveSoftTest, OptionsFollowTheTag) {
  Material m = Jelly();
  m.softness.young_modulus_Pa = 3e4;
  m.softness.poisson_ratio = 0.499;
  m.softness.fibre_ratio = 7;
  m.softness.hardening = 2;
  m.softness.relaxation_time_s = 0.7;
  SoftBodyOptions options = SoftOptionsOf(m);
  EXPECT_EQ(options.moduli.young_modulus_Pa, 3e4);
  EXPECT_TRUE(CheckModuli(options.moduli).ok()) << "also at the tag's limit";
  EXPECT_EQ(options.moduli.fibre_ratio, 1) << "without a direction there are no fibres";
  EXPECT_EQ(options.hardening, 2);
  EXPECT_EQ(options.relaxation_time_s, 0.7);
  m.softness.fibre_direction_base = {0, 3, 4};
  options = SoftOptionsOf(m);
  EXPECT_EQ(options.moduli.fibre_ratio, 7);
  EXPECT_EQ(options.fibre, (Vec3{0, 3, 4}));
}

}  // namespace test_haptics_live
}  // namespace omni::haptics
