// The pen's render model: as the drawing has the pen, closed and fit to be drawn by anyone, and the committed bytes.
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <regex>
#include <set>

#include "scenes/generator/models/scene_models.h"

namespace omni::scenes {
namespace {

std::string ReadText(const std::string& name) {
  std::ifstream file(std::string(OMNI_SOURCE_DIR) + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(PenModelFile, MatchesTheCommittedFile) {
  const std::vector<unsigned char> made = WriteGlb(PenModel());
  const std::string kept = ReadText("layer/models/pen.glb");
  EXPECT_TRUE(std::equal(made.begin(), made.end(), kept.begin(), kept.end(), [](unsigned char a, char b) {
    return a == static_cast<unsigned char>(b);
  })) << "run pen_generator layer/models/pen.glb and look at what changed";
}

// The number of `key` in the section of a TOML file of ours.
double NumberIn(const std::string& file, const std::string& section, const std::string& key) {
  const std::string text = ReadText(file);
  const std::size_t start = text.find("\n[" + section + "]");
  EXPECT_NE(start, std::string::npos) << file << ": " << section;
  std::smatch found;
  const std::string rest = text.substr(start, text.find("\n[", start + 1) - start);
  EXPECT_TRUE(std::regex_search(rest, found, std::regex("\n" + key + " *= *([-+.0-9e]+)"))) << key;
  return found.empty() ? 0 : std::stod(found[1]);
}

TEST(PenModelFile, HasTheSizesOfTheDrawing) {
  const PenShape shape;
  EXPECT_EQ(shape.magnet_radius_m, NumberIn("manifests/device/omni.toml", "magnet", "radius_m"));
  EXPECT_EQ(shape.magnet_half_height_m, NumberIn("manifests/device/omni.toml", "magnet", "half_height_m"));
  EXPECT_EQ(shape.tip_offset_m, NumberIn("manifests/device/omni.toml", "magnet", "tip_offset_m"));
  EXPECT_EQ(shape.flange_m, NumberIn("manifests/device/build.toml", "pen", "flange_m"));
  EXPECT_EQ(shape.grip_diameter_m, NumberIn("manifests/device/build.toml", "pen", "grip_diameter_m"));
  EXPECT_EQ(shape.grip_length_m, NumberIn("manifests/device/build.toml", "pen", "grip_length_m"));
}

tinygltf::Model Loaded(const std::string& glb) {
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(loader.LoadBinaryFromMemory(&model, &error, &warning, reinterpret_cast<const unsigned char*>(glb.data()),
                                          static_cast<unsigned>(glb.size())))
      << error;
  EXPECT_EQ(error + warning, "");
  return model;
}

template <class T>
std::vector<T> Elements(const tinygltf::Model& model, int index, std::size_t per_element) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(index));
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  const auto& bytes = model.buffers.at(static_cast<std::size_t>(view.buffer)).data;
  std::vector<T> out(accessor.count * per_element);
  EXPECT_LE(view.byteOffset + accessor.byteOffset + out.size() * sizeof(T), bytes.size());
  std::memcpy(out.data(), bytes.data() + view.byteOffset + accessor.byteOffset, out.size() * sizeof(T));
  return out;
}

struct Drawn {
  std::vector<Vec> normals;
  Mesh mesh;
};

// All primitives of a mesh, as they are drawn.
Drawn DrawnOf(const tinygltf::Model& model, const tinygltf::Mesh& mesh) {
  Drawn drawn;
  for (const tinygltf::Primitive& primitive : mesh.primitives) {
    const auto first = static_cast<std::uint32_t>(drawn.mesh.positions.size());
    const auto positions = Elements<float>(model, primitive.attributes.at("POSITION"), 3);
    const auto normals = Elements<float>(model, primitive.attributes.at("NORMAL"), 3);
    EXPECT_EQ(positions.size(), normals.size());
    for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
      drawn.mesh.positions.emplace_back(positions[i], positions[i + 1], positions[i + 2]);
      drawn.normals.emplace_back(normals[i], normals[i + 1], normals[i + 2]);
    }
    EXPECT_EQ(model.accessors.at(static_cast<std::size_t>(primitive.indices)).componentType,
              TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
    const auto indices = Elements<std::uint16_t>(model, primitive.indices, 1);
    EXPECT_EQ(indices.size() % 3, 0U);
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
      for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(indices[i + k], positions.size() / 3) << mesh.name;
      drawn.mesh.triangles.push_back({first + indices[i], first + indices[i + 1], first + indices[i + 2]});
    }
  }
  return drawn;
}

TEST(PenModelFile, CanBeDrawnByAnyApplication) {
  const tinygltf::Model model = Loaded(ReadText("layer/models/pen.glb"));
  EXPECT_TRUE(model.extensionsRequired.empty());
  EXPECT_TRUE(model.extensionsUsed.empty());
  EXPECT_EQ(model.defaultScene, 0);
  ASSERT_EQ(model.scenes.size(), 1U);
  EXPECT_TRUE(model.images.empty());
  ASSERT_EQ(model.buffers.size(), 1U);
  EXPECT_TRUE(model.buffers[0].uri.empty());
  for (const tinygltf::Material& material : model.materials) EXPECT_EQ(material.alphaMode, "OPAQUE") << material.name;
  std::set<std::string> names;
  for (const tinygltf::Node& node : model.nodes) {
    EXPECT_TRUE(names.insert(node.name).second) << node.name;
    EXPECT_TRUE(node.translation.empty() && node.rotation.empty() && node.scale.empty() && node.matrix.empty())
        << node.name << ": a pose of identity must be the model at rest";
  }
  EXPECT_EQ(names, (std::set<std::string>{"pen", "magnet", "grip", "tip", "button"}));
}

TEST(PenModelFile, SurfacesAreClosedWithUnitNormals) {
  const tinygltf::Model model = Loaded(ReadText("layer/models/pen.glb"));
  std::size_t triangles = 0;
  for (const tinygltf::Mesh& mesh : model.meshes) {
    Drawn drawn = DrawnOf(model, mesh);
    triangles += drawn.mesh.triangles.size();
    for (const Vec& normal : drawn.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-3) << mesh.name;
    for (const Triangle& t : drawn.mesh.triangles) {
      const auto& p = drawn.mesh.positions;
      const Vec face = glm::normalize(glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
      for (const std::uint32_t v : t) EXPECT_GT(glm::dot(face, drawn.normals[v]), 0.7) << mesh.name;
    }
    Weld(drawn.mesh);
    EXPECT_EQ(OpenEdges(drawn.mesh), 0U) << mesh.name;
    EXPECT_GT(SignedVolume6(drawn.mesh), 0) << mesh.name;
  }
  EXPECT_GT(triangles, 300U);
  EXPECT_LT(triangles, 1500U);
}

struct Extent {
  Vec lower{1.0}, upper{-1.0};
};
Extent ExtentOf(const tinygltf::Model& model, const std::string& name) {
  const auto found = std::find_if(model.meshes.begin(), model.meshes.end(),
                                  [&](const tinygltf::Mesh& mesh) { return mesh.name == name; });
  Extent extent;
  if (found == model.meshes.end()) return extent;
  for (const Vec& p : DrawnOf(model, *found).mesh.positions) {
    extent.lower = glm::min(extent.lower, p);
    extent.upper = glm::max(extent.upper, p);
  }
  return extent;
}

// Frame T: tip at the origin, everything else behind it.
TEST(PenModelFile, LiesInTheToolFrame) {
  const tinygltf::Model model = Loaded(ReadText("layer/models/pen.glb"));
  const PenShape shape;
  const Extent tip = ExtentOf(model, "tip"), magnet = ExtentOf(model, "magnet"), grip = ExtentOf(model, "grip");
  const Extent button = ExtentOf(model, "button");
  EXPECT_NEAR(tip.lower.z, 0, 1e-6);
  EXPECT_NEAR(magnet.lower.z, shape.tip_offset_m - shape.magnet_half_height_m, 1e-6);
  EXPECT_GT(tip.upper.z, magnet.lower.z + 0.001) << "the nib still ends inside of the magnet when it is pushed in";
  EXPECT_NEAR(grip.upper.z, shape.tip_offset_m + shape.magnet_half_height_m + shape.flange_m + shape.grip_length_m,
              1e-6);
  EXPECT_NEAR(magnet.upper.x, shape.magnet_radius_m, 1e-6);
  EXPECT_NEAR(magnet.lower.y, -shape.magnet_radius_m, 1e-6);
  EXPECT_GT(button.upper.y, shape.grip_diameter_m / 2 + 0.0008) << "the button is seen while it is pressed";
  EXPECT_LT(button.lower.y, shape.grip_diameter_m / 2 - 0.0008) << "no gap below it";
}

}  // namespace
}  // namespace omni::scenes
