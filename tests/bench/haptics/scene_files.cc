#include "tests/bench/haptics/scene_files.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>
#include <stdexcept>

#include <nlohmann/json.hpp>

#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

#include "tests/scene/exporters.h"

namespace omni::bench {
namespace {

using nlohmann::json;

constexpr std::size_t kImageSide = 1024;

// A .glb under construction: views are appended, JSON elements refer to them.
struct Glb {
  json document = {{"asset", {{"version", "2.0"}}},
                   {"scene", 0},
                   {"scenes", {{{"nodes", json::array()}}}},
                   {"nodes", json::array()},
                   {"meshes", json::array()},
                   {"accessors", json::array()},
                   {"bufferViews", json::array()},
                   {"images", json::array()},
                   {"textures", json::array()},
                   {"materials", json::array()}};
  std::string bin;

  template <class T>
  std::size_t View(const std::vector<T>& values, std::size_t stride = 0) {
    json view = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", values.size() * sizeof(T)}};
    if (stride > 0) view["byteStride"] = stride;
    bin.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    bin.resize((bin.size() + 3) / 4 * 4, '\0');
    document["bufferViews"].push_back(view);
    return document["bufferViews"].size() - 1;
  }
  std::size_t Accessor(json accessor) {
    document["accessors"].push_back(std::move(accessor));
    return document["accessors"].size() - 1;
  }
  std::size_t Mesh(std::size_t positions, std::size_t indices, std::size_t material) {
    document["meshes"].push_back(
        {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", material}}}}});
    return document["meshes"].size() - 1;
  }
  json& Node(std::size_t mesh, const std::string& name) {
    document["scenes"][0]["nodes"].push_back(document["nodes"].size());
    document["nodes"].push_back({{"mesh", mesh}, {"name", name}});
    return document["nodes"].back();
  }
  void Write(const std::string& path) {
    document["buffers"] = {{{"byteLength", bin.size()}}};
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto word = [](std::size_t value) {
      std::string bytes(4, '\0');
      for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<char>(value >> (8 * i) & 0xFF);
      return bytes;
    };
    std::ofstream file(path, std::ios::binary);
    file << "glTF" << word(2) << word(28 + text.size() + bin.size()) << word(text.size()) << "JSON" << text
         << word(bin.size()) << std::string("BIN\0", 4) << bin;
    file.close();
    if (!file) throw std::runtime_error(path + ": cannot be written");
  }
};

struct Body {
  std::vector<float> positions;  // glTF frame, m
  std::vector<std::uint32_t> indices;
  std::size_t vertices() const { return positions.size() / 3; }
};

// A closed torus with ripples, 40 mm wide, over the hull; about 2 n^2 triangles.
Body Torus(std::size_t n, double phase) {
  Body body;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const double u = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      const double v = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(n);
      const double r = 0.006 + 0.0003 * std::sin(9 * u + phase) * std::cos(7 * v);
      const double ring = 0.014 + r * std::cos(v);
      for (const double c : {ring * std::cos(u), 0.055 + r * std::sin(v), -ring * std::sin(u)}) {
        body.positions.push_back(static_cast<float>(c));
      }
      const auto at = [n](std::size_t a, std::size_t b) { return static_cast<std::uint32_t>(a % n * n + b % n); };
      body.indices.insert(body.indices.end(), {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      body.indices.insert(body.indices.end(), {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return body;
}

std::size_t AddIndices(Glb& glb, const Body& body) {
  return glb.Accessor({{"bufferView", glb.View(body.indices)},
                       {"componentType", 5125},
                       {"count", body.indices.size()},
                       {"type", "SCALAR"}});
}

std::size_t AddBody(Glb& glb, const Body& body, std::size_t material) {
  const std::size_t positions = glb.Accessor({{"bufferView", glb.View(body.positions)},
                                              {"componentType", 5126},
                                              {"count", body.vertices()},
                                              {"type", "VEC3"}});
  return glb.Mesh(positions, AddIndices(glb, body), material);
}

// Noise does not compress, like a photograph of a surface.
std::vector<unsigned char> NoisePng(std::mt19937_64& random) {
  std::vector<unsigned char> pixels(kImageSide * kImageSide * 3);
  for (unsigned char& c : pixels) c = static_cast<unsigned char>(random() & 0xFF);
  std::vector<unsigned char> png;
  const auto take = [](void* to, void* data, int size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    static_cast<std::vector<unsigned char>*>(to)->insert(static_cast<std::vector<unsigned char>*>(to)->end(), bytes,
                                                         bytes + size);
  };
  constexpr int kSide = static_cast<int>(kImageSide);
  if (stbi_write_png_to_func(take, &png, kSide, kSide, 3, pixels.data(), 3 * kSide) == 0) {
    throw std::runtime_error("no PNG could be made");
  }
  return png;
}

// 24 images with their materials, and as many bodies of 40,000 triangles each that show them.
Glb Textured(std::uint64_t seed, std::uint64_t divisor) {
  Glb glb;
  std::mt19937_64 random(seed);
  const std::vector<unsigned char> png = NoisePng(random);
  const auto n = static_cast<std::size_t>(std::sqrt(20'000.0 / static_cast<double>(divisor)));
  for (std::size_t k = 0; k < std::max<std::size_t>(24 / divisor, 2); ++k) {
    glb.document["images"].push_back({{"bufferView", glb.View(png)}, {"mimeType", "image/png"}});
    glb.document["textures"].push_back({{"source", k}});
    glb.document["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", k}}}}}});
    const Body body = Torus(n, static_cast<double>(random() % 1000));
    const std::size_t mesh = AddBody(glb, body, k);
    std::vector<float> normals_and_uv(5 * body.vertices(), 0.5F);
    const std::size_t view = glb.View(normals_and_uv, 20);
    json& attributes = glb.document["meshes"][mesh]["primitives"][0]["attributes"];
    const auto accessor = [&](std::size_t offset, const char* type) {
      return glb.Accessor({{"bufferView", view},
                           {"byteOffset", offset},
                           {"componentType", 5126},
                           {"count", body.vertices()},
                           {"type", type}});
    };
    attributes["NORMAL"] = accessor(0, "VEC3");
    attributes["TEXCOORD_0"] = accessor(12, "VEC2");
    glb.Node(mesh, "part " + std::to_string(k));
  }
  return glb;
}

// The first body's stiffness follows its image.
void TagWithTexture(Glb& glb) {
  glb.document["extensions"]["MPEG_haptic_material"]["materials"] = {
      {{"stiffness", {{{"texture", {{"index", 0}}}, {"type", "High_Resolution"}}}},
       {"extensions", {{"OMNI_haptic_material", {{"stiffness", 800}}}}}}};
  glb.document["meshes"][0]["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 0;
}

void AddSmallTagged(Glb& glb) {
  const std::size_t mesh = AddBody(glb, Torus(20, 0), 0);
  glb.Node(mesh, "felt")["extras"]["haptic"]["stiffness"] = 600;
}

// 16-bit positions, normalised, in rows of 8 bytes; the node's transform scales them back.
Glb Quantised(const Body& body) {
  Glb glb;
  std::vector<std::int16_t> rows;
  for (std::size_t i = 0; i < body.vertices(); ++i) {
    const float* p = &body.positions[3 * i];
    for (const double c : {p[0] / 0.025, (p[1] - 0.055) / 0.025, p[2] / 0.025}) {
      rows.push_back(static_cast<std::int16_t>(std::lround(c * 32767)));
    }
    rows.push_back(0);
  }
  const std::size_t positions = glb.Accessor({{"bufferView", glb.View(rows, 8)},
                                              {"componentType", 5122},
                                              {"normalized", true},
                                              {"count", body.vertices()},
                                              {"type", "VEC3"}});
  json& node = glb.Node(glb.Mesh(positions, AddIndices(glb, body), 0), "quantised");
  node["scale"] = {0.025, 0.025, 0.025};
  node["translation"] = {0, 0.055, 0};
  node["extras"]["haptic"] = true;
  glb.document["materials"].push_back(json::object());
  return glb;
}

// Position, normal and texture coordinate in rows of 32 bytes.
Glb Interleaved(const Body& body) {
  Glb glb;
  std::vector<float> rows;
  for (std::size_t i = 0; i < body.vertices(); ++i) {
    rows.insert(rows.end(), {body.positions[3 * i], body.positions[3 * i + 1], body.positions[3 * i + 2]});
    rows.insert(rows.end(), {0, 1, 0, 0.5F, 0.5F});
  }
  const std::size_t positions = glb.Accessor(
      {{"bufferView", glb.View(rows, 32)}, {"componentType", 5126}, {"count", body.vertices()}, {"type", "VEC3"}});
  glb.Node(glb.Mesh(positions, AddIndices(glb, body), 0), "interleaved")["extras"]["haptic"] = true;
  glb.document["materials"].push_back(json::object());
  return glb;
}

// A tenth of the positions replaced by sparse values.
Glb Sparse(const Body& body) {
  Glb glb;
  std::vector<std::uint32_t> indices;
  std::vector<float> values;
  for (std::size_t i = 0; i < body.vertices(); i += 10) {
    indices.push_back(static_cast<std::uint32_t>(i));
    values.insert(values.end(), {body.positions[3 * i], body.positions[3 * i + 1], body.positions[3 * i + 2]});
  }
  json sparse = {{"count", indices.size()},
                 {"indices", {{"bufferView", glb.View(indices)}, {"componentType", 5125}}},
                 {"values", {{"bufferView", glb.View(values)}}}};
  const std::size_t positions = glb.Accessor({{"bufferView", glb.View(body.positions)},
                                              {"componentType", 5126},
                                              {"count", body.vertices()},
                                              {"type", "VEC3"},
                                              {"sparse", sparse}});
  glb.Node(glb.Mesh(positions, AddIndices(glb, body), 0), "sparse")["extras"]["haptic"] = true;
  glb.document["materials"].push_back(json::object());
  return glb;
}

Glb Plain(const Body& body) {
  Glb glb;
  glb.Node(AddBody(glb, body, 0), "body")["extras"]["haptic"] = true;
  glb.document["materials"].push_back(json::object());
  return glb;
}

// As an exporter compresses it.
void WriteStyle(const Glb& plain, const std::string& style, const std::string& path) {
  const scene::test::Model model{.json = plain.document, .bin = plain.bin};
  const auto* const row = std::find_if(std::begin(scene::test::kStyles), std::end(scene::test::kStyles),
                                       [&](const scene::test::Style& other) { return other.name == style; });
  std::ofstream file(path, std::ios::binary);
  file << scene::test::Exporter(model, *row).Export().Bytes();
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace

std::vector<BenchFile> WriteBenchFiles(const std::string& folder, std::uint64_t seed, std::uint64_t divisor) {
  std::vector<BenchFile> files;
  const auto write = [&](Glb& glb, const std::string& name, bool tagged) {
    files.push_back({name, folder + "/" + name + ".glb", tagged});
    glb.Write(files.back().path);
  };
  const auto write_body = [&](Glb glb, const std::string& name) { write(glb, name, true); };
  {
    Glb textured = Textured(seed, divisor);
    write(textured, "textured-100MB", false);
    AddSmallTagged(textured);
    write(textured, "textured-100MB-one-tag", true);
    TagWithTexture(textured);
    write(textured, "textured-100MB-one-texture", true);
  }
  const Body body = Torus(static_cast<std::size_t>(std::sqrt(50'000.0 / static_cast<double>(divisor))), 1);
  write_body(Plain(body), "floats-100k");
  write_body(Quantised(body), "quantised-100k");
  write_body(Interleaved(body), "interleaved-100k");
  write_body(Sparse(body), "sparse-100k");
  const Glb large = Plain(Torus(static_cast<std::size_t>(std::sqrt(500'000.0 / static_cast<double>(divisor))), 2));
  write_body(large, "floats-1M");
  for (const auto& [name, style] : {std::pair("meshopt-1M", "gltfpack -c"), std::pair("draco-1M", "draco")}) {
    files.push_back({name, folder + "/" + name + ".glb", true});
    WriteStyle(large, style, files.back().path);
  }
  return files;
}

}  // namespace omni::bench
