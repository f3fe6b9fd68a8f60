// tinygltf as an independent judge: what our reader makes of a file's accessors is what tinygltf's model of the same
// file holds, decoded plainly here.
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numeric>
#include <random>
#include <set>

#include "service/scene/gltf/gltf_decode.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_decode_judge {

using Row = std::array<double, 4>;

double PlainComponent(const unsigned char* at, int type, bool normalized) {
  const auto read = [at](auto value) {
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
  };
  const auto part = [normalized](double number, double most) {
    return normalized ? std::max(number / most, -1.0) : number;
  };
  if (type == TINYGLTF_COMPONENT_TYPE_BYTE) return part(read(std::int8_t{}), 127);
  if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return part(read(std::uint8_t{}), 255);
  if (type == TINYGLTF_COMPONENT_TYPE_SHORT) return part(read(std::int16_t{}), 32767);
  if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return part(read(std::uint16_t{}), 65535);
  if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) return read(std::uint32_t{});
  return read(float{});
}

// All elements of an accessor.
std::vector<Row> Rows(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(index));
  const auto width = static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<unsigned>(accessor.type)));
  const auto bytes_of = [](int type) {
    return static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<unsigned>(type)));
  };
  const auto data = [&model](int view, std::size_t offset) {
    const tinygltf::BufferView& range = model.bufferViews.at(static_cast<std::size_t>(view));
    return model.buffers.at(static_cast<std::size_t>(range.buffer)).data.data() + range.byteOffset + offset;
  };
  const std::size_t bytes = bytes_of(accessor.componentType);
  std::vector<Row> rows(accessor.count);
  const auto fill = [&](Row& row, const unsigned char* at) {
    for (std::size_t c = 0; c < width; ++c)
      row[c] = PlainComponent(at + c * bytes, accessor.componentType, accessor.normalized);
  };
  if (accessor.bufferView >= 0) {
    const auto stride =
        static_cast<std::size_t>(accessor.ByteStride(model.bufferViews[static_cast<std::size_t>(accessor.bufferView)]));
    const unsigned char* first = data(accessor.bufferView, accessor.byteOffset);
    for (std::size_t i = 0; i < rows.size(); ++i) fill(rows[i], first + i * stride);
  }
  if (!accessor.sparse.isSparse) return rows;
  const auto& [numbers, values] = std::tie(accessor.sparse.indices, accessor.sparse.values);
  const unsigned char* number = data(numbers.bufferView, static_cast<std::size_t>(numbers.byteOffset));
  const unsigned char* value = data(values.bufferView, static_cast<std::size_t>(values.byteOffset));
  for (int i = 0; i < accessor.sparse.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double row = PlainComponent(number + at * bytes_of(numbers.componentType), numbers.componentType, false);
    fill(rows.at(static_cast<std::size_t>(row)), value + at * bytes * width);
  }
  return rows;
}

// Vertices of each triangle   [glTF 2.0, 3.7.2.1]
std::vector<std::array<std::size_t, 3>> Triangles(const tinygltf::Primitive& primitive, std::vector<std::size_t> run) {
  std::vector<std::array<std::size_t, 3>> triangles;
  for (std::size_t i = 0; i + 2 < run.size(); ++i) {
    if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      triangles.push_back({run[i], run[i + (1 + i % 2)], run[i + (2 - i % 2)]});
    } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      triangles.push_back({run[i + 1], run[i + 2], run[0]});
    } else if (i % 3 == 0) {
      triangles.push_back({run[i], run[i + 1], run[i + 2]});
    }
  }
  return triangles;
}

std::vector<Row> Attribute(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const char* name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? std::vector<Row>() : Rows(model, found->second);
}

tinygltf::Model ByTinyGltf(const std::string& path) {
  tinygltf::TinyGLTF reader;
  const auto no_picture = [](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int,
                             void*) { return true; };
  reader.SetImageLoader(no_picture, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const bool read = path.ends_with(".glb") ? reader.LoadBinaryFromFile(&model, &error, &warning, path)
                                           : reader.LoadASCIIFromFile(&model, &error, &warning, path);
  EXPECT_TRUE(read) << path << ": " << error;
  return model;
}

struct Compared {
  std::size_t primitives = 0, triangles = 0, coordinates = 0, normals = 0, colours = 0;
};

base::Vec3 First3(const Row& row) { return {row[0], row[1], row[2]}; }

void ExpectSamePrimitive(const tinygltf::Model& model, const tinygltf::Primitive& plain, const DecodedPrimitive& ours,
                         Compared& compared) {
  const std::vector<Row> positions = Attribute(model, plain, "POSITION"), normals = Attribute(model, plain, "NORMAL"),
                         colours = Attribute(model, plain, "COLOR_0");
  std::vector<std::size_t> run(positions.size());
  std::iota(run.begin(), run.end(), std::size_t{0});
  if (plain.indices >= 0) {
    run.clear();
    for (const Row& row : Rows(model, plain.indices)) run.push_back(static_cast<std::size_t>(row[0]));
  }
  const auto triangles = Triangles(plain, run);
  ASSERT_EQ(ours.triangles.size(), triangles.size());
  ASSERT_EQ(ours.normals.size(), normals.empty() ? 0 : ours.positions.size());
  ASSERT_EQ(ours.colours.size(), colours.empty() ? 0 : ours.positions.size());
  std::set<std::size_t> used;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t vertex = triangles[t][k], own = ours.triangles[t][k];
      used.insert(vertex);
      ASSERT_LT(own, ours.positions.size());
      ASSERT_EQ(ours.positions[own], First3(positions.at(vertex))) << "triangle " << t;
      if (!normals.empty()) {
        ASSERT_EQ(ours.normals[own], First3(normals.at(vertex))) << "triangle " << t;
      }
      if (!colours.empty()) {
        ASSERT_EQ(ours.colours[own], First3(colours.at(vertex))) << "triangle " << t;
      }
    }
  }
  EXPECT_EQ(ours.positions.size(), used.size()) << "each vertex that is used once, and no other";
  for (std::size_t set = 0; set < haptics::kMaxUvSets; ++set) {
    const std::vector<Row> uv = Attribute(model, plain, set == 0 ? "TEXCOORD_0" : "TEXCOORD_1");
    ASSERT_EQ(ours.uv[set].size(), uv.empty() ? 0 : triangles.size());
    for (std::size_t i = 0; i < 3 * ours.uv[set].size(); ++i) {
      const Row& row = uv.at(triangles[i / 3][i % 3]);
      ASSERT_EQ(ours.uv[set][i / 3][2 * (i % 3)], static_cast<float>(row[0])) << "corner " << i;
      ASSERT_EQ(ours.uv[set][i / 3][2 * (i % 3) + 1], static_cast<float>(row[1])) << "corner " << i;
    }
    compared.coordinates += ours.uv[set].size();
  }
  compared.primitives += 1;
  compared.triangles += triangles.size();
  compared.normals += ours.normals.size();
  compared.colours += ours.colours.size();
}

// Every primitive of the file, with all that our reader can take of it.
void ExpectSame(const std::string& path, Compared& compared) {
  SCOPED_TRACE(path);
  const tinygltf::Model model = ByTinyGltf(path);
  GltfFile file;
  LoadReport report;
  file.Open(path, {}, report);
  std::vector<MeshRequest> meshes;
  for (std::uint32_t mesh = 0; mesh < model.meshes.size(); ++mesh) {
    const std::vector<std::uint8_t> all_sets(model.meshes[mesh].primitives.size(), (1 << haptics::kMaxUvSets) - 1);
    meshes.push_back({.mesh = mesh, .uv_sets = all_sets, .paint = true});
  }
  const Subset subset = BuildSubset(file, meshes, {});
  const DecodedSubset decoded = DecodeSubset(subset);
  ASSERT_EQ(decoded.primitives.size(), subset.primitives.size()) << "none is skipped";
  for (std::size_t i = 0; i < decoded.primitives.size(); ++i) {
    const SubsetPrimitive& from = subset.primitives[i];
    SCOPED_TRACE(from.pointer);
    ASSERT_NO_FATAL_FAILURE(ExpectSamePrimitive(model, model.meshes.at(from.mesh).primitives.at(from.primitive),
                                                decoded.primitives[i], compared));
  }
}

std::string Base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
  }
  return text;
}

// A model of meshes with every kind of accessor that our reader takes.
class Generator {
 public:
  explicit Generator(unsigned seed) : random_(seed) {}

  Model Make() {
    model_.json = Json::parse(R"({"asset": {"version": "2.0"}, "meshes": [], "accessors": [], "bufferViews": []})");
    for (std::size_t mesh = 1 + Below(3); mesh > 0; --mesh) {
      Json primitives = Json::array();
      for (std::size_t i = 1 + Below(4); i > 0; --i) primitives.push_back(Primitive());
      model_.json["meshes"].push_back({{"primitives", std::move(primitives)}});
    }
    model_.json["buffers"] = Json::array({{{"byteLength", model_.bin.size()}}});
    return std::move(model_);
  }

 private:
  using Bits = std::function<std::uint32_t()>;  // of the next component

  std::size_t Below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }
  int OneOf(std::initializer_list<int> types) { return types.begin()[Below(types.size())]; }

  Json Primitive() {
    const std::size_t vertices = 3 + Below(60);
    Json json = {{"attributes", {{"POSITION", Vertices(vertices, 3, OneOf({5120, 5121, 5122, 5123, 5126}))}}}};
    Json& attributes = json["attributes"];
    for (const char* name : {"TEXCOORD_0", "TEXCOORD_1"})
      if (Below(2) == 0) attributes[name] = Vertices(vertices, 2, OneOf({5120, 5121, 5122, 5123, 5126}));
    if (Below(2) == 0) attributes["NORMAL"] = Vertices(vertices, 3, OneOf({5120, 5122, 5126}));
    if (Below(2) == 0) attributes["COLOR_0"] = Vertices(vertices, 3 + Below(2), OneOf({5121, 5123, 5126}));
    if (const std::size_t mode = Below(4); mode > 0) json["mode"] = 3 + mode;
    if (Below(4) > 0) {
      const Bits vertex = [this, vertices] { return static_cast<std::uint32_t>(Below(vertices)); };
      json["indices"] = Accessor(Below(100), 1, OneOf({5121, 5123, 5125}), false, vertex);
    }
    return json;
  }

  std::size_t Vertices(std::size_t count, std::size_t width, int type) {
    const Bits bits = [this, type] {
      const auto any = static_cast<std::uint32_t>(random_());
      return type == 5126 ? std::bit_cast<std::uint32_t>(static_cast<float>(static_cast<std::int32_t>(any)) * 1e-9F)
                          : any;
    };
    return Accessor(count, width, type, true, bits);
  }

  static std::size_t BytesOf(int type) {
    return type == 5120 || type == 5121 ? 1 : type == 5122 || type == 5123 ? 2 : 4;
  }

  std::string Element(std::size_t width, int type, const Bits& bits) {
    std::string bytes;
    for (std::size_t c = 0; c < width; ++c) bytes += Word(bits()).substr(0, BytesOf(type));
    return bytes;
  }

  // Rows `stride` apart, behind a few bytes of something else. stride 0: next to each other.
  Json View(std::size_t count, std::size_t width, int type, std::size_t stride, std::size_t before, const Bits& bits) {
    std::string rows(before, '\x5A');
    for (std::size_t i = 0; i < count; ++i) {
      rows += Element(width, type, bits);
      if (stride > 0 && i + 1 < count) rows.resize(before + (i + 1) * stride, '\x5A');
    }
    model_.bin.resize((model_.bin.size() + 3) / 4 * 4, '\0');
    Json view = {{"buffer", 0}, {"byteOffset", model_.bin.size()}, {"byteLength", rows.size()}};
    if (stride > 0) view["byteStride"] = stride;
    model_.bin += rows;
    model_.json["bufferViews"].push_back(std::move(view));
    return model_.json["bufferViews"].size() - 1;
  }

  std::size_t Accessor(std::size_t count, std::size_t width, int type, bool vertices, const Bits& bits) {
    constexpr const char* kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    count = std::max<std::size_t>(count, 1);
    Json json = {{"componentType", type}, {"type", kTypes[width]}, {"count", count}};
    if (vertices && type != 5126) json["normalized"] = Below(2) == 0;
    const bool sparse = Below(3) == 0;
    if (!sparse || !vertices || Below(2) == 0) {  // tinygltf takes no indices without data
      const std::size_t element = width * BytesOf(type), before = 4 * Below(3);
      const std::size_t stride = vertices && Below(2) == 0 ? (element + 3) / 4 * 4 + 4 * Below(3) : 0;
      json["bufferView"] = View(count, width, type, stride, before, bits);
      if (before > 0) json["byteOffset"] = before;
    }
    if (sparse) json["sparse"] = Sparse(count, width, type, bits);
    model_.json["accessors"].push_back(std::move(json));
    return model_.json["accessors"].size() - 1;
  }

  Json Sparse(std::size_t count, std::size_t width, int type, const Bits& bits) {
    std::vector<std::uint32_t> changed;
    for (std::uint32_t i = 0; i < count; ++i)
      if (i == 0 || Below(3) == 0) changed.push_back(i);
    const int index_type = OneOf({5121, 5123, 5125});
    std::size_t next = 0;
    const Bits index = [&] { return changed[next++]; };
    const std::size_t before = 4 * Below(3);
    return {{"count", changed.size()},
            {"indices",
             {{"bufferView", View(changed.size(), 1, index_type, 0, before, index)},
              {"byteOffset", before},
              {"componentType", index_type}}},
            {"values", {{"bufferView", View(changed.size(), width, type, 0, before, bits)}, {"byteOffset", before}}}};
  }

  std::mt19937 random_;
  Model model_;
};

// As binary glTF, with a data URI, or with a file beside it.
std::string WriteAs(std::size_t container, Model model, const TempFolder& folder) {
  if (container == 0) return folder.Write("model.glb", model.Bytes());
  model.json["buffers"][0]["uri"] =
      container == 1 ? "data:application/octet-stream;base64," + Base64(model.bin) : "model.bin";
  folder.Write("model.bin", model.bin);
  return folder.Write("model.gltf", model.json.dump());
}

TEST(SceneDecodeJudge, GeneratedModelsMatchTinyGltf) {
  const TempFolder folder;
  Compared compared;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    ASSERT_NO_FATAL_FAILURE(ExpectSame(WriteAs(seed % 3, Generator(seed).Make(), folder), compared));
  }
  // Otherwise this test has checked little.
  EXPECT_GT(compared.primitives, 1000U);
  EXPECT_GT(compared.triangles, 20'000U);
  EXPECT_GT(compared.coordinates, 20'000U);
  EXPECT_GT(compared.normals, 5'000U);
  EXPECT_GT(compared.colours, 5'000U);
}

TEST(SceneDecodeJudge, ShippedScenesMatchTinyGltf) {
  for (const char* name : {"dragon", "extrusion", "racetrack"}) {
    Compared compared;
    ExpectSame(std::string(OMNI_BINARY_DIR "/share/omni/scenes/") + name + ".glb", compared);
    EXPECT_GT(compared.triangles, 100U) << name;
  }
}

}  // namespace test_scene_decode_judge
}  // namespace omni::scene::test
