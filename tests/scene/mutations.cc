// Ten thousand damaged files: each is loaded or refused with a message, never more. scripts/fuzz runs more than a test
// run has time for, by OMNI_FUZZ.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "service/haptics/haptics.h"
#include "service/haptics/scene/check_scene.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/state.h"
#include "tests/scene/compressed.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_mutations {

class Damage {
 public:
  explicit Damage(std::uint32_t seed) : random_(seed) {}
  std::size_t Below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  // A few bytes changed, cut out or doubled.
  std::string Bytes(std::string bytes) {
    const std::size_t changes = 1 + Below(4);
    for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) {
      const std::size_t at = Below(bytes.size());
      switch (Below(6)) {
        case 0:
          bytes.resize(at);
          break;
        case 1:
          bytes.erase(at, 1 + Below(8));
          break;
        case 2:
          bytes.insert(at, bytes.substr(Below(bytes.size()), 1 + Below(16)));
          break;
        default:
          bytes[at] = static_cast<char>(Below(256));
      }
    }
    return bytes;
  }

  // A value somewhere in the document replaced by something else: the syntax stays, the meaning breaks.
  void Value(Json& json) {
    if ((json.is_object() || json.is_array()) && !json.empty() && Below(8) != 0) {
      auto child = json.begin();
      std::advance(child, static_cast<std::ptrdiff_t>(Below(json.size())));
      if (Below(12) == 0) {
        json.erase(child);
      } else {
        Value(*child);
      }
      return;
    }
    static const Json kOdd = Json::parse(R"([null, true, -1, 0, 1, 2, 3, 7, 255, 65536, 4294967295, 4294967296,
      18446744073709551615, -9223372036854775808, 1.5, 1e308, -1e-308, "", "x", [], {}, [0], [[]], {"haptic": "wall"},
      5120, 5121, 5123, 5125, 5126, "VEC3", "SCALAR", "data:;base64,AAAA", [0, 1], {"count": 1}])");
    json = kOdd[Below(kOdd.size())];
  }

 private:
  std::mt19937 random_;
};

// A model with most of the features at once.
Model Rich() {
  Model model = Tetra();
  model.bin += Bytes(std::vector<std::uint8_t>{2, 0, 0, 0}) + Bytes(std::vector<float>{0, 0.065F, 0});
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  model.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 72}, {"byteLength", 4}});
  model.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 76}, {"byteLength", 12}});
  model.json["accessors"][0]["sparse"] =
      Json::parse(R"({"count": 1, "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 3}})");
  model.json["nodes"] = Json::parse(R"([
    {"children": [1, 2], "translation": [0, 0.01, 0], "rotation": [0, 0, 0, 1], "extras": {"haptic": {"stiffness": 100}}},
    {"mesh": 0, "scale": [1, -1, 1], "extras": {"haptic.role": "wall"}},
    {"children": [3], "extras": {"haptic": {"role": "joystick", "range": 0.01}}},
    {"extras": {"haptic": {"role": "vehicle"}}, "extensions": {"KHR_physics_rigid_bodies": {"collider": {"physicsMaterial": 0}}}}])");
  model.json["extensions"] = Json::parse(R"({"MPEG_haptic_material": {"materials": [{"extensions":
    {"OMNI_haptic_material": {"softness": {"model": "winkler"}, "extrude": {"step": 0.004}, "magnet": {"range": 0.01}}}}]},
    "KHR_physics_rigid_bodies": {"physicsMaterials": [{"staticFriction": 0.4}]}})");
  model.json["meshes"][0]["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 0;
  model.json["materials"][0]["extensions"]["OMNI_haptic_material"]["material"] = 0;
  Json& primitive = model.json["meshes"][0]["primitives"][0];
  const auto vertices = [&model](const std::string& bytes, int component, const char* type) {
    return AddAccessor(model, bytes, {{"componentType", component}, {"count", 4}, {"type", type}});
  };
  primitive["attributes"]["JOINTS_0"] = vertices(Bytes(std::vector<std::uint8_t>(16, 1)), 5121, "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = vertices(Bytes(std::vector<float>(16, 0.25F)), 5126, "VEC4");
  primitive["targets"] = {{{"POSITION", vertices(Bytes(std::vector<float>(12, 0.001F)), 5126, "VEC3")}}};
  model.json["meshes"][0]["weights"] = {0.5};
  model.json["skins"] = Json::parse(R"([{"joints": [0, 2]}])");
  model.json["skins"][0]["inverseBindMatrices"] =
      AddAccessor(model, Bytes(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                                  1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}),
                  {{"componentType", 5126}, {"count", 2}, {"type", "MAT4"}});
  model.json["nodes"][1]["skin"] = 0;
  model.json["nodes"][1]["extensions"] = Json::parse(R"({"KHR_node_visibility": {"visible": true}})");
  return model;
}

void ExpectLoadedOrRefused(const std::string& file, bool fit, std::size_t& refused) {
  LoadOptions options = kTouchAll;
  options.fit = fit;
  const Loaded loaded = Load(file, options);
  if (loaded.result.ok()) {
    for (const haptics::InputObject& object : loaded.result->objects) {
      ASSERT_EQ(object.triangles.size(), object.triangle_material.size());
      for (const auto& triangle : object.triangles) {
        for (const std::uint32_t v : triangle) ASSERT_LT(v, object.vertices_base_m.size());
      }
      for (const std::uint16_t m : object.triangle_material) ASSERT_LT(m, loaded.result->materials.size());
      for (const base::Vec3& p : object.vertices_base_m)
        ASSERT_TRUE(p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0);
    }
  } else {
    ++refused;
    ASSERT_EQ(loaded.result.error().rfind(file + ": ", 0), 0U) << loaded.result.error();
    ASSERT_GE(loaded.result.error().size(), file.size() + 10);
  }
}

std::size_t Wanted() {
  const char* asked = std::getenv("OMNI_FUZZ");
  return asked == nullptr ? 5000 : std::strtoul(asked, nullptr, 10);
}

// For scripts/fuzz.
void Record(std::size_t files, std::size_t refused) {
  testing::Test::RecordProperty("files", static_cast<int>(files));
  testing::Test::RecordProperty("refused", static_cast<int>(refused));
}

TEST(SceneMutations, WhatIsDamagedLoadsWhole) {
  for (const Model& model : {Tetra(), Rich(), MeshoptTetra(), DracoTetra(true)}) {
    const Loaded loaded = LoadBytes(model.Bytes());
    EXPECT_TRUE(loaded.result.ok()) << loaded.result.error();
  }
}

TEST(SceneMutations, DamagedBytesLoadOrAreRejected) {
  const TempFolder folder;
  Damage damage(11);
  const std::string models[] = {Tetra().Bytes(), Rich().Bytes(), MeshoptTetra().Bytes(), DracoTetra(true).Bytes()};
  const std::size_t files = Wanted();
  std::size_t refused = 0;
  for (std::size_t i = 0; i < files; ++i) {
    const std::string file = folder.Write("damaged.glb", damage.Bytes(models[i % 4]));
    ASSERT_NO_FATAL_FAILURE(ExpectLoadedOrRefused(file, i % 3 == 0, refused)) << i;
  }
  Record(files, refused);
  EXPECT_GT(refused, files / 5);
  EXPECT_LT(refused, files);
}

TEST(SceneMutations, DamagedJsonValuesLoadOrAreRejected) {
  const TempFolder folder;
  Damage damage(12);
  const Model models[] = {Tetra(), Rich(), MeshoptTetra(), DracoTetra(true)};
  const std::size_t files = Wanted();
  std::size_t refused = 0;
  for (std::size_t i = 0; i < files; ++i) {
    Model model = models[i % 4];
    const std::size_t changes = 1 + damage.Below(3);
    for (std::size_t k = 0; k < changes; ++k) damage.Value(model.json);
    const std::string file = folder.Write("damaged.glb", model.Bytes());
    ASSERT_NO_FATAL_FAILURE(ExpectLoadedOrRefused(file, i % 3 == 0, refused)) << i << " " << model.json.dump();
  }
  Record(files, refused);
  EXPECT_GT(refused, files / 5);
  EXPECT_LT(refused, files);
}

TEST(SceneMutations, DamagedShippedScenesLoadOrAreRejected) {
  const TempFolder folder;
  Damage damage(13);
  std::size_t refused = 0;
  for (const char* name : {"extrusion.glb", "racetrack.glb", "dragon.glb"}) {
    const std::string whole = ReadAll(std::string(OMNI_SOURCE_DIR) + "/scenes/" + name);
    ASSERT_GT(whole.size(), 10'000U) << name;
    std::uint32_t json_bytes = 0;
    std::memcpy(&json_bytes, &whole[12], 4);
    const int count = std::string(name) == "dragon.glb" ? 40 : 200;
    for (int i = 0; i < count; ++i) {
      std::string bytes = whole;
      // Mostly in the JSON: damaged positions are still positions.
      for (int k = 0; k < 3; ++k) {
        bytes[damage.Below(i % 2 == 0 ? 20 + json_bytes : bytes.size())] = static_cast<char>(damage.Below(256));
      }
      if (i % 5 == 0) bytes.resize(damage.Below(bytes.size()));
      ASSERT_NO_FATAL_FAILURE(ExpectLoadedOrRefused(folder.Write("damaged.glb", bytes), false, refused))
          << name << " " << i;
    }
  }
  EXPECT_GT(refused, 50U);
}

// A pen that pokes around in a scene: whatever the scene is, its force is finite and within the limit.
void ExpectSoundForces(const haptics::Scene& scene, Damage& damage) {
  haptics::Config config;
  haptics::Input input;
  input.tracked = true;
  input.limit.valid = true;
  input.limit.ampere_per_newton = {5, 0, 0, 0, 5, 0, 0, 0, 5};
  input.limit.current_max_A = {15, 15, 15};
  input.limit.force_max_N = 2;
  haptics::State state;
  haptics::Output output;
  haptics::EnterScene(scene, state);
  for (int i = 0; i < 60; ++i) {
    const auto somewhere = [&] { return 0.06 * static_cast<double>(damage.Below(1000)) / 1000 - 0.03; };
    input.device_point_base_m = {somewhere(), somewhere(), 0.03 + somewhere()};
    input.t_ns += 1'000'000;
    haptics::Step(config, scene, input, state, output);
    const base::Vec3& f = output.force_base_N;
    ASSERT_LE(Norm(f), 2.0 + 1e-9);
  }
}

TEST(SceneMutations, DamagedBlocksAreRejectedOrGiveBoundedForces) {
  Loaded loaded = Load(std::string(OMNI_SOURCE_DIR) + "/scenes/racetrack.glb");
  ASSERT_TRUE(loaded.result.ok());
  haptics::BuildReport report;
  const base::Result<haptics::Scene> scene = haptics::BuildScene(loaded.scene(), report);
  ASSERT_TRUE(scene.ok());
  ASSERT_TRUE(haptics::CheckScene(*scene).ok());
  Damage damage(14);
  std::size_t refused = 0;
  constexpr int kRuns = 3000;
  for (int i = 0; i < kRuns; ++i) {
    haptics::SceneBlock block(scene->block().begin(), scene->block().end());
    // The header, the materials or anything; a byte, or a word that is large, -1 or not a number.
    const std::size_t range = i % 3 == 0 ? sizeof(haptics::SceneHeader) : (i % 3 == 1 ? 2048 : block.size());
    for (std::size_t k = 0; k <= damage.Below(3); ++k) {
      const std::size_t at = damage.Below(range - 8) / 8 * 8;
      constexpr std::uint64_t kWords[] = {~0ULL, 0x7FF8000000000000ULL, 0x7FEFFFFFFFFFFFFFULL, 0,
                                          0xFFFFFFFF00000000ULL};
      const std::uint64_t word = kWords[damage.Below(std::size(kWords))];
      if (damage.Below(2) == 0) block[at] = static_cast<std::byte>(damage.Below(256));
      if (damage.Below(2) == 0) std::memcpy(&block[at], &word, 4U << damage.Below(2));
    }
    if (i % 50 == 0) block.resize(damage.Below(block.size()));
    const haptics::Scene damaged(std::move(block));
    if (!haptics::CheckScene(damaged).ok()) {
      ++refused;
    } else {
      ASSERT_NO_FATAL_FAILURE(ExpectSoundForces(damaged, damage)) << i;
    }
  }
  EXPECT_GT(refused, kRuns / 4U);
  EXPECT_LT(refused, static_cast<std::size_t>(kRuns));
}

}  // namespace test_scene_mutations
}  // namespace omni::scene::test
