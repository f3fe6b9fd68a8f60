// The same solid in many encodings loads as the same solid.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_transforms {

class Random {
 public:
  explicit Random(std::uint32_t seed) : random_(seed) {}
  double In(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool Coin() { return (random_() & 1U) != 0; }

 private:
  std::mt19937 random_;
};

// |det| of the chain of scales multiplies the volume, and its sign never turns the solid inside out.
TEST(SceneTransforms, VolumeFollowsTheScalesOfTheHierarchy) {
  Random random(21);
  for (int run = 0; run < 200; ++run) {
    Model model = Tetra();
    model.json["nodes"] = Json::array();
    const int levels = 1 + run % 6;
    double factor = 1;
    for (int i = 0; i < levels; ++i) {
      Json node = {{"translation", {random.In(-1, 1), random.In(-1, 1), random.In(-1, 1)}}};
      const double q[4] = {random.In(-1, 1), random.In(-1, 1), random.In(-1, 1), random.In(-1, 1)};
      const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      node["rotation"] = {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
      double s[3];
      for (double& axis : s) axis = random.In(0.5, 2) * (random.Coin() ? -1 : 1);
      factor *= std::abs(s[0] * s[1] * s[2]);
      node["scale"] = {s[0], s[1], s[2]};
      if (i + 1 < levels) node["children"] = {i + 1};
      if (i + 1 == levels) node["mesh"] = 0;
      model.json["nodes"].push_back(node);
    }
    Loaded loaded = LoadBytes(model.Bytes());
    ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
    // Volumes about the solid's own corner: far from the origin the plain sum loses digits.
    haptics::InputObject object = loaded.scene().objects[0];
    const base::Vec3 o = object.vertices_base_m[0];
    for (base::Vec3& p : object.vertices_base_m) p = {p.x - o.x, p.y - o.y, p.z - o.z};
    EXPECT_NEAR(SignedVolume6(object) / (1e-6 * factor), 1, 1e-5);
  }
}

// Offsets, strides, index types and component types are packing, not shape.
TEST(SceneTransforms, ShapeDoesNotDependOnBufferPacking) {
  Random random(22);
  for (int run = 0; run < 200; ++run) {
    Model model = Tetra();
    const bool words = random.Coin();  // positions as unsigned shorts, 1 um each
    const auto element = words ? std::size_t{6} : std::size_t{12};
    const std::size_t stride = (element + 3) / 4 * 4 + 4 * static_cast<std::size_t>(random.In(0, 5));
    const std::size_t lead = 4 * static_cast<std::size_t>(random.In(0, 9)),
                      inner = 4 * static_cast<std::size_t>(random.In(0, 9));
    std::string bin(lead + inner + stride * 3 + element, '\x7F');
    const std::vector<float> positions = TetraPositions();
    for (std::size_t v = 0; v < 4; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto word = static_cast<std::uint16_t>(std::lround(positions[3 * v + k] * 1e6F));
        const std::string bytes =
            words ? Bytes(std::vector<std::uint16_t>{word}) : Bytes(std::vector<float>{positions[3 * v + k]});
        bin.replace(lead + inner + v * stride + k * bytes.size(), bytes.size(), bytes);
      }
    }
    Json& json = model.json;
    json["bufferViews"][0] = {
        {"buffer", 0}, {"byteOffset", lead}, {"byteLength", bin.size() - lead}, {"byteStride", stride}};
    json["accessors"][0]["byteOffset"] = inner;
    json["accessors"][0]["componentType"] = words ? 5123 : 5126;
    if (words) json["nodes"][0]["scale"] = {1e-6, 1e-6, 1e-6};
    bin.resize((bin.size() + 3) / 4 * 4);
    const int index_type = run % 3;
    std::string indices;
    for (const std::uint16_t i : TetraIndices()) {
      if (index_type == 0) indices += static_cast<char>(i);
      if (index_type == 1) indices += Bytes(std::vector<std::uint16_t>{i});
      if (index_type == 2) indices += Word(i);
    }
    json["bufferViews"][1] = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", indices.size()}};
    json["accessors"][1]["componentType"] = index_type == 0 ? 5121 : index_type == 1 ? 5123 : 5125;
    model.bin = bin + indices;
    json["buffers"][0]["byteLength"] = model.bin.size();
    Loaded loaded = LoadBytes(model.Bytes());
    ASSERT_TRUE(loaded.result.ok()) << loaded.result.error() << json.dump();
    EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]) / 1e-6, 1, 1e-4) << json.dump();
  }
}

}  // namespace test_scene_transforms
}  // namespace omni::scene::test
