// Coordinates so far from their origin that the steps between floats can be felt.
#include <gtest/gtest.h>

#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_float_steps {

// A tetrahedron of 10 mm, 3e5 m away, that its node moves back: what exporters make of geographic coordinates.
Model BakedFarAway(float away) {
  Model model = Tetra();
  std::vector<float> positions = TetraPositions();
  for (std::size_t k = 0; k < positions.size(); k += 3) positions[k] += away;
  model.bin = Bytes(positions) + Bytes(TetraIndices());
  model.json["nodes"][0]["translation"] = {-away, 0, 0};
  return model;
}

TEST(SceneFloatSteps, CoarseCoordinatesAreWarnedAboutOnce) {
  Model model = BakedFarAway(299'510.456F);
  model.json["nodes"].push_back(model.json["nodes"][0]);
  model.json["scenes"][0]["nodes"] = {0, 1};
  const Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  const std::string all = loaded.Warnings();
  const std::size_t at = all.find("/nodes/0: vertices lie at 3e+05 m, where a float step is 31 mm: move the model");
  ASSERT_NE(at, std::string::npos) << all;
  EXPECT_EQ(all.find("float step", at + 60), std::string::npos) << all;
}

TEST(SceneFloatSteps, CoordinatesAreMeasuredAsTheyAreFelt) {
  const auto warned = [](const Model& model, const LoadOptions& options) {
    const Loaded loaded = LoadBytes(model.Bytes(), options);
    EXPECT_TRUE(loaded.result.ok()) << loaded.result.error();
    return loaded.Warnings().find("float step") != std::string::npos;
  };
  EXPECT_TRUE(warned(BakedFarAway(1000), kTouchAll)) << "0.06 mm";
  EXPECT_FALSE(warned(BakedFarAway(500), kTouchAll)) << "0.03 mm";
  Model millimetres = BakedFarAway(10'000);
  millimetres.json["nodes"][0]["scale"] = {0.001, 0.001, 0.001};
  EXPECT_FALSE(warned(millimetres, kTouchAll));
  LoadOptions large = kTouchAll;
  large.scale = 10;
  EXPECT_TRUE(warned(BakedFarAway(500), large));
  Model quantised = Tetra();  // exact wherever its node puts it
  quantised.bin = Bytes(std::vector<std::int16_t>{0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 0}) +
                  std::string(16, '\0') + Bytes(TetraIndices());
  quantised.json["bufferViews"][0]["byteStride"] = 8;
  quantised.json["accessors"][0]["componentType"] = 5122;
  quantised.json["nodes"][0]["translation"] = {0, 0.05, 0};
  quantised.json["nodes"][0]["scale"] = {1e-4, 1e-4, 1e-4};
  EXPECT_FALSE(warned(quantised, kTouchAll));
}

}  // namespace test_scene_float_steps
}  // namespace omni::scene::test
