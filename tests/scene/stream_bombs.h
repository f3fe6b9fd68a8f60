// Files whose compressed streams cost a reader as much as they can, each of about the given number of bytes at most.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/scene/compressed.h"
#include "tests/support/bombs.h"

namespace omni::scene::test {

namespace streams {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr std::size_t kMostVertices = 11'999'997;  // of 4 million triangles that share none
constexpr std::size_t kMostTriangles = 3'900'000;

// Without data of its own yet.
inline Model Empty() {
  Model model = Tetra();
  model.bin.clear();
  model.json["bufferViews"] = Json::array();
  model.json["buffers"][0]["byteLength"] = 0;
  return model;
}

// Views of as many bytes as fit that are decoded to nothing.
inline std::string EmptyViews(std::size_t n) {
  Model model = Tetra();
  const std::size_t at = Append(model, std::string(n / 2, '\1'));
  model.json["buffers"].push_back({{"byteLength", 4}});
  for (std::size_t i = 0; i < n / 800; ++i) {
    const Json compressed = {{"buffer", 0},      {"byteOffset", at}, {"byteLength", n / 2},
                             {"byteStride", 12}, {"count", 0},       {"mode", "ATTRIBUTES"}};
    model.json["accessors"].push_back(
        {{"bufferView", model.json["bufferViews"].size()}, {"componentType", 5126}, {"count", 0}, {"type", "VEC3"}});
    model.json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 0}, {"extensions", {{kMeshopt, compressed}}}});
    model.json["meshes"][0]["primitives"].push_back(
        {{"attributes", {{"POSITION", model.json["accessors"].size() - 1}}}});
  }
  return model.Bytes();
}

// Zeros: each view, of the same bytes, is decoded to 64 times as many.
inline std::string SharedStream(std::size_t n) {
  Model model = Empty();
  const std::size_t count = std::max<std::size_t>(n / 16, 3);
  const std::string encoded = MeshoptVertices(std::string(4 * count, '\0'), 4);
  const std::size_t at = Append(model, encoded);
  model.json["accessors"] = Json::array();
  model.json["meshes"][0]["primitives"] = Json::array();
  for (std::size_t i = 0; i < std::max<std::size_t>(n / 500, 1); ++i) {
    const Json compressed = {{"buffer", 0},     {"byteOffset", at}, {"byteLength", encoded.size()},
                             {"byteStride", 4}, {"count", count},   {"mode", "ATTRIBUTES"}};
    model.json["bufferViews"].push_back(
        {{"buffer", 1}, {"byteLength", 4 * count}, {"byteStride", 4}, {"extensions", {{kMeshopt, compressed}}}});
    model.json["accessors"].push_back({{"bufferView", i}, {"componentType", 5121}, {"count", 3}, {"type", "VEC3"}});
    model.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", i}}}});
  }
  model.json["buffers"].push_back({{"byteLength", 4}});
  return model.Bytes();
}

// As many vertices as may be, all at one place.
inline std::string Zeros(std::size_t n) {
  Model model = Empty();
  const std::size_t count = std::min(16 * n, kMostVertices) / 3 * 3;
  model.json["bufferViews"].push_back({{"byteStride", 4}});
  Compress(model, 0, MeshoptVertices(std::string(4 * count, '\0'), 4), count, 4, "ATTRIBUTES");
  model.json["accessors"][0]["count"] = count;
  model.json["accessors"][0]["componentType"] = 5121;
  model.json["meshes"][0]["primitives"][0].erase("indices");
  return model.Bytes();
}

// The same four triangles, again and again.
inline std::string Repeats(std::size_t n) {
  Model model = MeshoptTetra(true, 4);
  const Triangles four = TetraTriangles();
  std::vector<unsigned> corners;
  for (std::size_t i = 0; i < std::min(n / 5, kMostTriangles); ++i)
    corners.insert(corners.end(), four[i % 4].begin(), four[i % 4].end());
  Compress(model, 1, MeshoptIndices(corners, true), corners.size(), 4, "TRIANGLES");
  model.json["accessors"][1]["count"] = corners.size();
  return model.Bytes();
}

// A flat plate: next to nothing by Draco. `unread`: attributes of four numbers that no accessor names.
inline Model DracoPlate(std::size_t vertices, std::size_t unread, bool edgebreaker = true) {
  Model model = Empty();
  const auto side = std::max(2U, static_cast<std::uint32_t>(std::sqrt(static_cast<double>(vertices))));
  vertices = std::size_t{side} * side;
  std::vector<float> positions;
  Triangles triangles;
  for (std::uint32_t i = 0; i < side; ++i) {
    for (std::uint32_t j = 0; j < side; ++j) {
      positions.insert(positions.end(), {1e-4F * static_cast<float>(i), 0.05F, 1e-4F * static_cast<float>(j)});
      const std::uint32_t at = i * side + j;
      if (i + 1 == side || j + 1 == side) continue;
      triangles.push_back({at, at + 1, at + side});
      triangles.push_back({at + 1, at + side + 1, at + side});
    }
  }
  std::vector<DracoAttribute> attributes{
      {"POSITION", draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, Bytes(positions)}};
  const std::vector<DracoAttribute> read = attributes;
  for (std::size_t i = 0; i < unread; ++i) {
    attributes.push_back(
        {"", draco::GeometryAttribute::GENERIC, draco::DT_UINT32, 4, std::string(16 * vertices, '\0')});
  }
  model.json["accessors"][0]["count"] = vertices;
  model.json["accessors"][1]["count"] = 3 * triangles.size();
  model.json["accessors"][1]["componentType"] = 5125;
  UseDraco(model, EncodeDraco(triangles, vertices, attributes, edgebreaker, 12), read);
  return model;
}

inline std::string Unread(std::size_t n) {
  Model model = DracoPlate(std::min<std::size_t>(n / 4, 10'000), 100);
  return model.Bytes();
}

// One small stream, decoded again for each of many views.
inline std::string SharedDraco(std::size_t n) {
  Model model = DracoPlate(1400, 0);
  const Json view = model.json["bufferViews"][0], primitive = model.json["meshes"][0]["primitives"][0];
  const std::size_t triangles = model.json["accessors"][1]["count"].get<std::size_t>() / 3;
  for (std::size_t i = 1; i < std::min(n / 400, kMostTriangles / triangles); ++i) {
    model.json["bufferViews"].push_back(view);
    model.json["meshes"][0]["primitives"].push_back(primitive);
    model.json["meshes"][0]["primitives"][i]["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = i;
  }
  return model.Bytes();
}

// Notes in notes, before what is a mesh.
inline std::string NestedMetadata(std::size_t n) {
  std::string stream("DRACO\2\2\1\1\0\200\0", 12);                // has metadata; of no attribute
  while (stream.size() < n) stream += std::string("\0\1\1a", 4);  // no entry, one part named "a"
  Model model = Empty();
  UseDraco(model, stream, {TetraDracoPositions()});
  return model.Bytes();
}

}  // namespace streams

// Each was or could be slow or large, or end the process.
inline const std::array kStreamBombs = {
    omni::test::Bomb{"views that are decoded to nothing", streams::EmptyViews},
    omni::test::Bomb{"views of one stream", streams::SharedStream},
    omni::test::Bomb{"vertices of zeros", streams::Zeros},
    omni::test::Bomb{"triangles that repeat", streams::Repeats},
    omni::test::Bomb{"Draco attributes that nothing reads", streams::Unread},
    omni::test::Bomb{"views of one Draco stream", streams::SharedDraco},
    omni::test::Bomb{"nested Draco metadata", streams::NestedMetadata},
};

}  // namespace omni::scene::test
