// Textures that tags name are read, decoded and sampled; no other image is.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <stb/stb_image_write.h>

#include "service/haptics/contact/effects.h"
#include "service/haptics/contact/relief.h"
#include "service/haptics/scene/check_scene.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/load_scene.h"
#include "tests/haptics/scenario.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_textures {

using Pixels = std::vector<unsigned char>;

void Take(void* to, void* data, int size) {
  static_cast<std::string*>(to)->append(static_cast<char*>(data), static_cast<std::size_t>(size));
}

std::string Png(int width, int height, int channels, const Pixels& pixels) {
  std::string bytes;
  EXPECT_NE(stbi_write_png_to_func(Take, &bytes, width, height, channels, pixels.data(), width * channels), 0);
  return bytes;
}

// 4 x 2 pixels; red rises by 30 a pixel, row after row; green and blue are something else.
std::string Stairs() {
  Pixels pixels;
  for (int i = 0; i < 8; ++i) pixels.insert(pixels.end(), {static_cast<unsigned char>(30 * i), 7, 200});
  return Png(4, 2, 3, pixels);
}

double RedOfStairs(int column, int row) { return 30.0 * (4 * row + column) / 255; }

// A square from (0, 0) to (0.02, 0.02) m of the base's x, y, 50 mm up, its coordinates (u, v) = (x, y) / 0.02, with a
// tag whose stiffness is multiplied by `image`.
Model Square(const std::string& image) {
  Model model;
  const std::vector<float> positions = {0, 0.05F, 0, 0.02F, 0.05F, 0, 0.02F, 0.05F, -0.02F, 0, 0.05F, -0.02F};
  const std::vector<float> uv = {0, 0, 1, 0, 1, 1, 0, 1};
  const std::vector<std::uint16_t> indices = {0, 1, 2, 0, 2, 3};
  model.bin = Bytes(positions) + Bytes(uv) + Bytes(indices) + image;
  model.json = Json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "square", "mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}],
                "extensions": {"MPEG_haptic_material": {"hapticMaterialIndex": 0}}}],
    "extensions": {"MPEG_haptic_material": {"materials": [{
      "stiffness": [{"texture": {"index": 0}, "type": "High_Resolution"}],
      "extensions": {"OMNI_haptic_material": {"stiffness": 800}}}]}},
    "textures": [{"source": 0}], "images": [{"bufferView": 3, "mimeType": "image/png"}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                  {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                    {"buffer": 0, "byteOffset": 80, "byteLength": 12}, {"buffer": 0, "byteOffset": 92}],
    "buffers": [{}]})");
  model.json["bufferViews"][3]["byteLength"] = image.size();
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  return model;
}

Json& Entry(Model& model) { return model.json["extensions"]["MPEG_haptic_material"]["materials"][0]["stiffness"][0]; }

struct Rendered {
  haptics::Scene scene;
  LoadReport load;
  std::string error;

  // At (u, v) of the square.
  double At(double u, double v) const {
    const std::int32_t texture = scene.materials()[scene.triangles()[0].material].stiffness_texture;
    const base::Vec3 p{0.02 * u, 0.02 * v, 0.05};
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
      std::array<base::Vec3, 3> c;
      for (std::size_t k = 0; k < 3; ++k) {
        const haptics::Vertex& vertex = scene.vertices()[scene.triangles()[t].vertex[k]];
        c[k] = {vertex.x, vertex.y, vertex.z};
      }
      const auto area = [](const base::Vec3& a, const base::Vec3& b, const base::Vec3& d) {
        return (b.x - a.x) * (d.y - a.y) - (b.y - a.y) * (d.x - a.x);
      };
      const double whole = area(c[0], c[1], c[2]);
      const std::array<double, 3> w{area(p, c[1], c[2]) / whole, area(c[0], p, c[2]) / whole,
                                    area(c[0], c[1], p) / whole};
      if (w[0] >= -1e-9 && w[1] >= -1e-9 && w[2] >= -1e-9)
        return static_cast<double>(haptics::SampleTexture(scene, texture, t, w));
    }
    return -1;
  }
};

Rendered Render(const Model& model) {
  const TempFolder folder;
  Rendered rendered;
  haptics::BuildReport build;
  auto scene = LoadScene(folder.Write("square.glb", model.Bytes()), {}, nullptr, rendered.load, build);
  if (scene.ok()) {
    rendered.scene = std::move(*scene);
    EXPECT_TRUE(haptics::CheckScene(rendered.scene).ok());
  } else {
    rendered.error = scene.error();
  }
  return rendered;
}

std::string WarningsOf(const Rendered& rendered) {
  std::string all;
  for (const std::string& line : rendered.load.warnings) all += line + "\n";
  return all;
}

TEST(SceneTextures, SamplesRedChannelBilinearly) {
  const Rendered rendered = Render(Square(Stairs()));
  ASSERT_EQ(rendered.error, "");
  EXPECT_EQ(WarningsOf(rendered), "");
  EXPECT_EQ(rendered.load.images_decoded, 1U);
  EXPECT_EQ(rendered.scene.materials()[rendered.scene.triangles()[0].material].stiffness_N_m, 800);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 4; ++column) {  // centres of texels
      EXPECT_NEAR(rendered.At((column + 0.5) / 4, (row + 0.5) / 2), RedOfStairs(column, row), 1e-6) << column << row;
    }
  }
  EXPECT_NEAR(rendered.At(0.25, 0.25), (RedOfStairs(0, 0) + RedOfStairs(1, 0)) / 2, 1e-6);
  EXPECT_NEAR(rendered.At(0.375, 0.5), (RedOfStairs(1, 0) + RedOfStairs(1, 1)) / 2, 1e-6);
  // At the left border repeat mixes in the right end.
  EXPECT_NEAR(rendered.At(0, 0.25), (RedOfStairs(0, 0) + RedOfStairs(3, 0)) / 2, 1e-6);
}

TEST(SceneTextures, HonoursSamplerWrapModes) {
  Model model = Square(Stairs());
  model.json["samplers"] = Json::parse(R"([{"wrapS": 33071, "wrapT": 33648}])");
  model.json["textures"][0]["sampler"] = 0;
  const Rendered clamp = Render(model);
  EXPECT_NEAR(clamp.At(0, 0.25), RedOfStairs(0, 0), 1e-6);
  EXPECT_NEAR(clamp.At(0.125, 0), RedOfStairs(0, 0), 1e-6) << "mirrored at the edge: itself";
  model.json["samplers"][0]["wrapS"] = 5;
  EXPECT_NE(WarningsOf(Render(model)).find("/samplers/0/wrapS"), std::string::npos);
}

TEST(SceneTextures, HonoursTextureTransformAndTexCoord) {
  Model model = Square(Stairs());
  Entry(model)["texture"]["extensions"]["KHR_texture_transform"] =
      Json::parse(R"({"offset": [0.25, 0.5], "scale": [0.5, 0.5], "rotation": 0})");
  Rendered rendered = Render(model);
  // u' = u / 2 + 1/4, v' = v / 2 + 1/2
  EXPECT_NEAR(rendered.At(0.25, 0.5), RedOfStairs(1, 1), 1e-6);
  // A quarter turn: (u, v) -> (v, -u) by the extension's matrix [c s; -s c].
  Entry(model)["texture"]["extensions"]["KHR_texture_transform"] = Json::parse(R"({"rotation": 1.5707963267948966})");
  rendered = Render(model);
  EXPECT_NEAR(rendered.At(0.25, 0.125), RedOfStairs(0, 1), 1e-5) << "u' = 0.125, v' = -0.25 = 0.75";
  // The other set of coordinates, by both ways to say it.
  model = Square(Stairs());
  model.json["meshes"][0]["primitives"][0]["attributes"] = Json::parse(R"({"POSITION": 0, "TEXCOORD_1": 1})");
  Entry(model)["texture"]["texCoord"] = 1;
  EXPECT_NEAR(Render(model).At(0.125, 0.25), 0.0, 1e-6);
  EXPECT_NEAR(Render(model).At(0.875, 0.75), RedOfStairs(3, 1), 1e-6);
  Entry(model)["texture"]["texCoord"] = 0;
  Entry(model)["texture"]["extensions"]["KHR_texture_transform"]["texCoord"] = 1;
  EXPECT_NEAR(Render(model).At(0.875, 0.75), RedOfStairs(3, 1), 1e-6);
}

TEST(SceneTextures, SharedImageIsDecodedOnce) {
  Model model = Square(Stairs());
  Json& material = model.json["extensions"]["MPEG_haptic_material"]["materials"][0];
  material["friction"] = material["stiffness"];
  material["vibrotactileTexture"] = material["stiffness"][0];  // without the list, as a person writes it
  const Rendered rendered = Render(model);
  ASSERT_EQ(rendered.error, "");
  const haptics::Material& m = rendered.scene.materials()[0];
  EXPECT_EQ(m.stiffness_texture, 0);
  EXPECT_EQ(m.friction_texture, 0);
  EXPECT_EQ(m.vibrotactile_texture, 0);
  EXPECT_EQ(rendered.scene.textures().size(), 1U);
  EXPECT_EQ(rendered.scene.texels().size(), 8U);
  EXPECT_EQ(rendered.load.images_decoded, 1U);
}

TEST(SceneTextures, ReadsOnlyTheReferencedImage) {
  Model model = Square(Stairs());
  const std::string other(500'000, 'x');
  for (std::size_t i = 0; i < 3; ++i) {
    model.json["images"].push_back({{"bufferView", model.json["bufferViews"].size()}, {"mimeType", "image/png"}});
    model.json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", model.bin.size()}, {"byteLength", other.size()}});
    model.bin += other;
  }
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  const Rendered rendered = Render(model);
  ASSERT_EQ(rendered.error, "");
  EXPECT_EQ(rendered.load.images_decoded, 1U);
  EXPECT_LT(rendered.load.bytes_read, 10'000U);
}

// So many squares, each with a tag and an image of its own; all images in the same bytes, or each in its own.
Model Squares(int count, const std::string& image, bool same_bytes) {
  Model model = Square(image);
  Json& json = model.json;
  for (int i = 1; i < count; ++i) {
    if (!same_bytes) {
      json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", model.bin.size()}, {"byteLength", image.size()}});
      model.bin += image;
    }
    json["images"].push_back({{"bufferView", json["bufferViews"].size() - 1}, {"mimeType", "image/png"}});
    json["textures"].push_back({{"source", i}});
    Json material = json["extensions"]["MPEG_haptic_material"]["materials"][0];
    material["stiffness"][0]["texture"]["index"] = i;
    json["extensions"]["MPEG_haptic_material"]["materials"].push_back(material);
    Json mesh = json["meshes"][0];
    mesh["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = i;
    json["meshes"].push_back(mesh);
    json["nodes"].push_back({{"mesh", i}});
    json["scenes"][0]["nodes"].push_back(i);
  }
  json["buffers"][0]["byteLength"] = model.bin.size();
  return model;
}

TEST(SceneTextures, ImageCountSharingAndTexelsAreLimited) {
  const Rendered many = Render(Squares(66, Stairs(), false));
  ASSERT_EQ(many.error, "");
  EXPECT_EQ(many.load.images_decoded, 64U);
  EXPECT_NE(WarningsOf(many).find("is beyond the limit of 64 images"), std::string::npos) << WarningsOf(many);

  Pixels noise(90'000);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<unsigned char>(i * i * 2654435761U >> 13);
  const Rendered shared = Render(Squares(5, Png(300, 300, 1, noise), true));
  ASSERT_EQ(shared.error, "");
  EXPECT_EQ(shared.load.images_decoded, 1U);
  EXPECT_NE(WarningsOf(shared).find("is among images that share their bytes"), std::string::npos) << WarningsOf(shared);

  // 2 kB each, and 16 million texels.
  const Rendered large = Render(Squares(6, Png(4096, 4096, 1, Pixels(4096 * 4096)), false));
  ASSERT_EQ(large.error, "");
  EXPECT_EQ(large.load.images_decoded, 4U);
  EXPECT_NE(WarningsOf(large).find("with the images before it"), std::string::npos) << WarningsOf(large);
}

TEST(SceneTextures, MissingOrInvalidTextureWarnsAndSamplesAsOne) {
  struct Case {
    std::function<void(Model&)> spoil;
    const char* warning;
  };
  const Case cases[] = {
      {[](Model& m) { m.bin[95] = 'x'; }, "neither PNG nor JPEG"},
      {[](Model& m) {
         m.bin.resize(130);
         m.json["buffers"][0]["byteLength"] = 130;
       },
       "has no image"},
      {[](Model& m) {
         for (std::size_t i = 135; i < m.bin.size(); ++i) m.bin[i] = 0;
       },
       "/images/0"},
      {[](Model& m) {
         m.json["images"][0] = {{"uri", "not_there.png"}};
       },
       "not_there.png"},
      {[](Model& m) {
         m.json["images"][0] = {{"uri", "../x.png"}};
       },
       "/images/0/uri"},
      {[](Model& m) { m.json["images"][0] = Json::object(); }, "neither bufferView nor uri"},
      {[](Model& m) { m.json["textures"][0] = Json::object(); }, "/textures/0"},
      {[](Model& m) { Entry(m)["texture"]["index"] = 9; }, "/stiffness/0/texture/index"},
      {[](Model& m) { Entry(m)["texture"] = 5; }, "/stiffness/0/texture"},
      {[](Model& m) { Entry(m)["type"] = "Reference"; }, "not rendered"},
      {[](Model& m) { Entry(m)["texture"]["texCoord"] = 2; }, "only TEXCOORD_0 and _1"},
      {[](Model& m) { Entry(m)["texture"]["texCoord"] = 1; }, "has no TEXCOORD_1"},
      {[](Model& m) {
         Entry(m)["texture"]["extensions"]["KHR_texture_transform"]["scale"] = {1e9, 1};
       },
       "million"},
  };
  for (const Case& c : cases) {
    Model model = Square(Stairs());
    c.spoil(model);
    const Rendered rendered = Render(model);
    ASSERT_EQ(rendered.error, "") << c.warning;
    EXPECT_NE(WarningsOf(rendered).find(c.warning), std::string::npos)
        << WarningsOf(rendered) << "\nexpected " << c.warning;
    EXPECT_EQ(rendered.At(0.3, 0.7), 1) << c.warning;
  }
}

TEST(SceneTextures, TooManyPixelsAreNotDecoded) {
  std::string image = Stairs();
  const auto big_endian = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) image[at + i] = static_cast<char>(value >> (24 - 8 * i) & 0xFF);
  };
  big_endian(16, 8192);  // IHDR: width, height
  big_endian(20, 8192);
  const Rendered rendered = Render(Square(image));
  ASSERT_EQ(rendered.error, "");
  EXPECT_NE(WarningsOf(rendered).find("8192 x 8192 pixels"), std::string::npos) << WarningsOf(rendered);
}

TEST(SceneTextures, DamagedImagesAreDecodedOrNotUsed) {
  std::uint32_t random = 12345;
  const std::string image = Stairs();
  int used = 0;
  for (int i = 0; i < 600; ++i) {
    std::string damaged = image;
    for (int k = 0; k < 3; ++k) {
      random = random * 1664525U + 1013904223U;
      damaged[8 + (random >> 8) % (damaged.size() - 8)] = static_cast<char>(random >> 24);
    }
    if (i % 7 == 0) damaged.resize(9 + random % (damaged.size() - 9));
    const Rendered rendered = Render(Square(damaged));
    ASSERT_EQ(rendered.error, "") << i;
    const double value = rendered.At(0.4, 0.4);
    ASSERT_TRUE(value >= 0 && value <= 1) << i;
    used += rendered.load.images_decoded > 0;
  }
  EXPECT_GT(used, 0);
  EXPECT_LT(used, 600);
}

// What a material's normalTexture shows is what is felt: the square as the picture of a relief, by formula.
namespace relief {

constexpr int kPixels = 64;
constexpr double kSide_m = 0.02, kHigh_m = 2e-4, kLong_m = 0.005, kBroad_m = 0.01;

double HeightAt(double x, double y) {
  return kHigh_m * (std::sin(2 * std::numbers::pi * x / kLong_m) + 0.5 * std::cos(2 * std::numbers::pi * y / kBroad_m));
}

// Normals of the relief; green is up, which is towards -y.
std::string Normals() {
  Pixels pixels;
  for (int row = 0; row < kPixels; ++row) {
    for (int column = 0; column < kPixels; ++column) {
      const double x = kSide_m * (column + 0.5) / kPixels, y = kSide_m * (row + 0.5) / kPixels, e = 1e-7;
      const double along_x = (HeightAt(x + e, y) - HeightAt(x - e, y)) / (2 * e);
      const double along_y = (HeightAt(x, y + e) - HeightAt(x, y - e)) / (2 * e);
      const double length = std::hypot(1, along_x, along_y);
      for (const double n : {-along_x / length, along_y / length, 1 / length})
        pixels.push_back(static_cast<unsigned char>(std::lround(127.5 * (n + 1))));
    }
  }
  return Png(kPixels, kPixels, 3, pixels);
}

Model Plate(const std::string& image, const Json& haptic = {{"relief", 1}, {"staticFriction", 0}}) {
  Model model = Square(image);
  model.json["extensions"].clear();
  model.json["scenes"][0]["extras"] = {{"haptic", {{"tip", {{"radius", 0}}}}}};
  model.json["meshes"][0].erase("extensions");
  model.json["meshes"][0]["primitives"][0]["material"] = 0;
  model.json["materials"] = {{{"normalTexture", {{"index", 0}}}, {"extras", {{"haptic", haptic}}}}};
  return model;
}

TEST(SceneRelief, HasTheHeightsOfTheNormals) {
  const Rendered rendered = Render(Plate(Normals()));
  ASSERT_EQ(rendered.error, "");
  EXPECT_EQ(WarningsOf(rendered), "");
  ASSERT_EQ(rendered.scene.reliefs().size(), 1U);
  const haptics::Surface surface(rendered.scene, {});
  haptics::Random random(7);
  for (int k = 0; k < 500; ++k) {
    const base::Vec3 place{random.Uniform(0, kSide_m), random.Uniform(0, kSide_m), 0.05};
    for (std::uint32_t t = 0; t < 2; ++t) {  // either triangle: they lie in one plane
      const double height_m = haptics::ReliefHeight(rendered.scene, 0, surface, t, place, 0);
      // 8 bits leave a slope known to 0.004: over half a wave along x and y, 10 um each at most.
      ASSERT_NEAR(height_m, HeightAt(place.x, place.y), 2e-5) << k;
    }
    EXPECT_EQ(haptics::ReliefHeight(rendered.scene, 0, surface, 0, place, 1e6), 0) << "too fast to follow";
  }
}

TEST(SceneRelief, IsFeltAlongAStroke) {
  for (const double relief : {0.0, 1.0}) {
    Rendered rendered = Render(Plate(Normals(), {{"relief", relief}, {"staticFriction", 0}}));
    ASSERT_EQ(rendered.error, "");
    EXPECT_EQ(rendered.load.images_decoded, relief > 0 ? 1U : 0U);
    haptics::Pen pen(std::move(rendered.scene));
    constexpr double kDeep_m = 8e-4, kSpeed_m_s = 0.04;
    pen.MoveTo({0.001, 0.0077, 0.052});
    pen.Slide({0.001, 0.0077, 0.052}, {0.001, 0.0077, 0.05 - kDeep_m}, 200);
    double felt2 = 0, true2 = 0, both = 0;
    for (double x = 0.001; x < 0.019; x += 1e-3 * kSpeed_m_s) {
      pen.MoveTo({x, 0.0077, 0.05 - kDeep_m});
      const double height_m = HeightAt(x, 0.0077) - HeightAt(0, 0.0077);
      if (x < 0.006) continue;  // the place is not followed yet
      const double ripple_N = pen.output.force_base_N.z - 400 * (kDeep_m + HeightAt(0, 0.0077));
      felt2 += relief > 0 ? ripple_N * ripple_N : 0;
      true2 += height_m * height_m;
      both += ripple_N * height_m;
      if (relief == 0) {
        ASSERT_NEAR(pen.output.force_base_N.z, 400 * kDeep_m, 1e-3);
      }
    }
    if (relief == 0) continue;
    EXPECT_GT(both / std::sqrt(felt2 * true2), 0.95);
    EXPECT_NEAR(std::sqrt(felt2 / true2), 400, 60) << "N/m: stiffness times height";
  }
}

TEST(SceneRelief, WhatIsNotThereIsNotFelt) {
  struct Case {
    void (*change)(Model&);
    std::string image, warning;
  };
  const Case cases[] = {
      {[](Model& m) { m.json["materials"][0].erase("normalTexture"); }, Normals(), ""},
      {[](Model& m) { m.json["materials"][0]["normalTexture"]["scale"] = 1e9; }, Normals(), "is not within 100"},
      {[](Model& m) { m.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0"); }, Normals(),
       "it is not felt"},
      {[](Model&) {}, Png(2, 2, 1, {1, 2, 3, 4}), "is gray"},
      {[](Model&) {}, "no image", "is neither PNG nor JPEG"},
  };
  for (const Case& c : cases) {
    Model model = Plate(c.image);
    c.change(model);
    const Rendered rendered = Render(model);
    ASSERT_EQ(rendered.error, "") << c.warning;
    EXPECT_NE(WarningsOf(rendered).find(c.warning), std::string::npos) << WarningsOf(rendered);
    EXPECT_EQ(rendered.scene.materials()[rendered.scene.triangles()[0].material].relief, -1) << c.warning;
  }
}

// Heights take time: images beyond the limit are not decoded.
TEST(SceneRelief, HasALimitOfImages) {
  const std::string image = Normals();
  Model model = Plate(image);
  Json& json = model.json;
  for (std::size_t k = 1; k <= haptics::kMaxReliefs; ++k) {
    const std::size_t at = model.bin.size();
    model.bin += image;
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", image.size()}});
    json["images"].push_back({{"bufferView", 3 + k}, {"mimeType", "image/png"}});
    json["textures"].push_back({{"source", k}});
    json["materials"].push_back(json["materials"][0]);
    json["materials"][k]["normalTexture"]["index"] = k;
    json["meshes"][0]["primitives"].push_back(json["meshes"][0]["primitives"][0]);
    json["meshes"][0]["primitives"][k]["material"] = k;
  }
  json["buffers"][0]["byteLength"] = model.bin.size();
  const Rendered rendered = Render(model);
  ASSERT_EQ(rendered.error, "");
  EXPECT_EQ(rendered.scene.reliefs().size(), haptics::kMaxReliefs);
  EXPECT_EQ(rendered.load.images_decoded, haptics::kMaxReliefs);
  EXPECT_NE(WarningsOf(rendered).find("beyond the limit of 16 images with a relief"), std::string::npos)
      << WarningsOf(rendered);
}

// Flat, upright and inward normals, one texel, odd sizes: finite heights.
TEST(SceneRelief, IsFiniteForAnyImage) {
  haptics::Random random(11);
  for (int k = 0; k < 60; ++k) {
    const int width = 1 + static_cast<int>(random.Next() % 40), height = 1 + static_cast<int>(random.Next() % 40);
    Pixels pixels(static_cast<std::size_t>(3 * width * height));
    for (unsigned char& p : pixels) p = static_cast<unsigned char>(k % 3 == 0 ? 0 : random.Next());
    const Rendered rendered = Render(Plate(Png(width, height, 3, pixels)));
    ASSERT_EQ(rendered.error, "") << width << " x " << height;
    if (width == 1 && height == 1) {
      EXPECT_TRUE(rendered.scene.reliefs().empty());
      continue;
    }
    ASSERT_EQ(rendered.scene.reliefs().size(), 1U) << width << " x " << height;
    const haptics::Surface surface(rendered.scene, {});
    for (int i = 0; i < 20; ++i) {
      const base::Vec3 place{random.Uniform(0, kSide_m), random.Uniform(0, kSide_m), 0.05};
      const double height_m = haptics::ReliefHeight(rendered.scene, 0, surface, 0, place, 0);
      ASSERT_LT(std::abs(height_m), kSide_m) << width << " x " << height;
    }
  }
}

}  // namespace relief
}  // namespace test_scene_textures
}  // namespace omni::scene::test
