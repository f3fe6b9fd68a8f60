#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "scenes/generator/models/scene_models.h"
#include "service/haptics/geometry/triangle_math.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/scene_file.h"

namespace omni::scenes {
namespace {

std::string PathOf(const std::string& name) { return std::string(OMNI_SOURCE_DIR) + "/scenes/" + name; }

std::vector<unsigned char> ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void ExpectSame(const Document& document, const std::string& name) {
  const std::vector<unsigned char> made = WriteGlb(document), kept = ReadAll(PathOf(name));
  ASSERT_EQ(made.size(), kept.size()) << name << ": run scene_generator on scenes/ and look at what changed";
  const auto difference = std::mismatch(made.begin(), made.end(), kept.begin());
  EXPECT_TRUE(difference.first == made.end()) << name << " differs at byte " << difference.first - made.begin()
                                              << ": run scene_generator on scenes/ and look at what changed";
}

TEST(Regenerate, ExtrusionMatchesTheCommittedFile) { ExpectSame(ExtrusionScene(), "extrusion.glb"); }
TEST(Regenerate, RacetrackMatchesTheCommittedFile) { ExpectSame(RacetrackScene(), "racetrack.glb"); }
TEST(Regenerate, DragonMatchesTheCommittedFile) { ExpectSame(DragonScene(), "dragon.glb"); }

haptics::SceneInput Load(const std::string& name) {
  scene::LoadReport report;
  auto result = scene::LoadSceneFile(PathOf(name), {}, report);
  EXPECT_TRUE(result.ok()) << result.error();
  for (const std::string& warning : report.warnings) ADD_FAILURE() << warning;
  return result.ok() ? result.value() : haptics::SceneInput{};
}

Mesh AsMesh(const haptics::InputObject& object) {
  Mesh mesh;
  for (const base::Vec3& p : object.vertices_base_m) mesh.positions.emplace_back(p.x, p.y, p.z);
  for (const auto& [a, b, c] : object.triangles) mesh.triangles.push_back({a, b, c});
  Weld(mesh);
  return mesh;
}

void ExpectClosed(const haptics::InputObject& object) {
  const Mesh mesh = AsMesh(object);
  EXPECT_EQ(mesh.triangles.size(), object.triangles.size()) << object.name << ": degenerate triangles";
  EXPECT_EQ(OpenEdges(mesh), 0U) << object.name;
  EXPECT_GT(SignedVolume6(mesh), 0) << object.name;
}

struct Span {
  Vec lower{1.0}, upper{-1.0};
};
Span SpanOf(const haptics::InputObject& object) {
  Span span;
  for (const base::Vec3& p : object.vertices_base_m) {
    span.lower = {std::min(span.lower.x, p.x), std::min(span.lower.y, p.y), std::min(span.lower.z, p.z)};
    span.upper = {std::max(span.upper.x, p.x), std::max(span.upper.y, p.y), std::max(span.upper.z, p.z)};
  }
  return span;
}

TEST(Scenes, ExtrusionIsOneClosedSculptableBlock) {
  const haptics::SceneInput scene = Load("extrusion.glb");
  ASSERT_EQ(scene.objects.size(), 1U);
  const haptics::InputObject& block = scene.objects[0];
  ExpectClosed(block);
  EXPECT_GE(block.triangles.size(), 1000U);
  EXPECT_LE(block.triangles.size(), 2000U);
  const Span span = SpanOf(block);
  EXPECT_NEAR(span.upper.z, 0.045, 1e-6);
  EXPECT_NEAR(span.upper.x - span.lower.x, 0.040, 1e-5);
  ASSERT_EQ(scene.materials.size(), 1U);
  EXPECT_EQ(scene.materials[0].stiffness_N_m, 600);
  EXPECT_EQ(scene.materials[0].static_friction, 0.5);
  EXPECT_TRUE(scene.materials[0].sculpt.enabled);
  EXPECT_EQ(scene.materials[0].sculpt.snap_m, 0.002);
}

TEST(Scenes, DragonIsOneClosedSurfaceOfSoftRubber) {
  const haptics::SceneInput scene = Load("dragon.glb");
  ASSERT_EQ(scene.objects.size(), 1U);
  const haptics::InputObject& dragon = scene.objects[0];
  ExpectClosed(dragon);
  EXPECT_GE(dragon.triangles.size(), 10'000U);
  EXPECT_LE(dragon.triangles.size(), 30'000U);
  Mesh mesh = AsMesh(dragon);
  KeepLargestComponent(mesh);
  EXPECT_EQ(mesh.triangles.size(), dragon.triangles.size()) << "more than one piece";
  const Span span = SpanOf(dragon);
  for (int k = 0; k < 3; ++k) {
    EXPECT_GE(span.upper[k] - span.lower[k], 0.05) << k;
    EXPECT_LE(span.upper[k] - span.lower[k], 0.12) << k;
  }
  ASSERT_EQ(scene.materials.size(), 1U);
  EXPECT_EQ(scene.materials[0].softness.model, haptics::SoftnessModel::kTet);
  EXPECT_GE(scene.materials[0].softness.young_modulus_Pa, 2e4);
  EXPECT_LE(scene.materials[0].softness.young_modulus_Pa, 5e5);
}

TEST(Scenes, RacetrackHasWallsVehicleAndJoystick) {
  const haptics::SceneInput scene = Load("racetrack.glb");
  ASSERT_EQ(scene.objects.size(), 2U);
  for (const haptics::InputObject& wall : scene.objects) {
    ExpectClosed(wall);
    EXPECT_TRUE(wall.car_wall) << wall.name;
  }
  ASSERT_TRUE(scene.joystick.has_value());
  EXPECT_EQ(scene.joystick->centre_base_m.z, 0.047);
  ASSERT_TRUE(scene.vehicle.has_value());
  EXPECT_NEAR(scene.vehicle->start_base_m.z, 0.0398, 1e-6);
  const Span outer = SpanOf(scene.objects[0]);
  EXPECT_NEAR(outer.upper.x - outer.lower.x, 0.09, 0.012);
  EXPECT_NEAR(outer.upper.y - outer.lower.y, 0.06, 0.012);
  // The car starts on the road: clear of both walls by more than its radius, and between them.
  const base::Vec3& car = scene.vehicle->start_base_m;
  for (const haptics::InputObject& wall : scene.objects) {
    for (const base::Vec3& p : wall.vertices_base_m) {
      EXPECT_GT(std::hypot(p.x - car.x, p.y - car.y), scene.vehicle->radius_m + 0.003) << wall.name;
    }
  }
}

TEST(Scenes, RacetrackCheckpointsGoAroundTheRoad) {
  const haptics::SceneInput scene = Load("racetrack.glb");
  ASSERT_TRUE(scene.vehicle.has_value());
  const haptics::VehicleInput& car = *scene.vehicle;
  ASSERT_EQ(car.checkpoint_count, 4);
  haptics::BuildReport report;
  ASSERT_TRUE(haptics::BuildScene(scene, report).ok());
  for (const std::string& line : report.lines) {
    EXPECT_EQ(line.find("vehicle: starts"), std::string::npos) << line;
    EXPECT_EQ(line.find("its middle"), std::string::npos) << line;
  }
  // Driven the way round in which the angle about the middle grows, in equal parts.
  double last_rad = std::atan2(car.start_base_m.y, car.start_base_m.x);
  for (int k = 0; k < car.checkpoint_count; ++k) {
    const haptics::Checkpoint& line = car.checkpoints[static_cast<std::size_t>(k)];
    const double angle_rad = std::atan2(line.position_base_m.y, line.position_base_m.x);
    const double step_rad = std::remainder(angle_rad - last_rad, 2 * std::acos(-1.0));
    EXPECT_GT(step_rad, 0.5) << k;
    EXPECT_LT(std::abs(std::remainder(line.heading_rad - angle_rad - std::acos(0.0), 2 * std::acos(-1.0))), 0.9) << k;
    last_rad = angle_rad;
  }
}

// What is drawn, touchable or not, lies beside the housing, as people with a headset see it: nothing enters the hull.
TEST(Scenes, NothingEntersTheHousing) {
  constexpr double kHull_m = 0.0375;
  for (const Document& document : {ExtrusionScene(), DragonScene(), RacetrackScene()}) {
    double nearest_m = 1;
    for (const OutNode& node : document.nodes) {
      if (!node.mesh || node.name.starts_with("base")) continue;  // the housing itself, drawn
      const Mesh& mesh = document.meshes[*node.mesh].mesh;
      const double c = std::cos(node.heading_rad), s = std::sin(node.heading_rad);
      const auto at = [&](std::uint32_t i) {
        const Vec& p = mesh.positions[i];
        const Vec& o = node.translation_base_m;
        return base::Vec3{o.x + c * p.x - s * p.y, o.y + s * p.x + c * p.y, o.z + p.z};
      };
      for (const Triangle& t : mesh.triangles) {
        const haptics::Corners corners{at(t[0]), at(t[1]), at(t[2])};
        const double distance_m = Norm(haptics::ClosestOnTriangle(corners, {}).point);
        EXPECT_GT(distance_m, kHull_m) << document.title << ": " << node.name;
        nearest_m = std::min(nearest_m, distance_m);
      }
    }
    EXPECT_LT(nearest_m, kHull_m + 0.001) << document.title << ": lies on it, where the base is strong";
  }
}

// The stick moves inside the inner wall, and over everything.
TEST(Scenes, RacetracksStickIsClearOfItsWalls) {
  const haptics::SceneInput scene = Load("racetrack.glb");
  ASSERT_TRUE(scene.joystick.has_value());
  const base::Vec3& centre = scene.joystick->centre_base_m;
  for (const haptics::InputObject& wall : scene.objects) {
    for (const base::Vec3& p : wall.vertices_base_m) {
      EXPECT_GT(std::hypot(p.x - centre.x, p.y - centre.y), scene.joystick->range_m) << wall.name;
      EXPECT_LT(p.z, centre.z - 0.003) << wall.name;
    }
  }
}

// Hand paths: slow enough for a person, starting and ending clear of everything.
TEST(Scenes, HandPathsAreSlowAndEndClear) {
  for (const std::string name : {"extrusion", "dragon", "racetrack"}) {
    const std::vector<unsigned char> bytes = ReadAll(PathOf(name + ".hand.json"));
    const nlohmann::json script = nlohmann::json::parse(bytes.begin(), bytes.end());
    EXPECT_EQ(script.at("name"), name);
    double duration_s = 0;
    Vec last(0, 0, script.at("waypoints")[0].at("tip_m")[2].get<double>());
    for (const auto& waypoint : script.at("waypoints")) {
      const Vec tip(waypoint.at("tip_m")[0].get<double>(), waypoint.at("tip_m")[1].get<double>(),
                    waypoint.at("tip_m")[2].get<double>());
      const double leg_s = waypoint.at("s").get<double>();
      duration_s += leg_s;
      // Minimum jerk: the peak speed is 1.875 times the mean.
      if (leg_s > 0) {
        EXPECT_LT(1.875 * glm::length(tip - last) / leg_s, 0.10) << name << " after " << duration_s << " s";
      }
      EXPECT_GE(tip.z, 0.033);
      last = tip;
    }
    EXPECT_GE(duration_s, 12) << name;
    EXPECT_LE(duration_s, 16) << name;
    EXPECT_GE(last.z, 0.055) << name;
  }
}

}  // namespace
}  // namespace omni::scenes
