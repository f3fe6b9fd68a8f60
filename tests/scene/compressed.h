// Files with compressed meshes, made by the encoders of the libraries that ours are decoded by.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <meshoptimizer.h>

#include "tests/scene/files.h"

namespace omni::scene::test {

inline constexpr const char* kMeshopt = "EXT_meshopt_compression";

inline std::string MeshoptVertices(const std::string& bytes, std::size_t stride) {
  const std::size_t count = bytes.size() / stride;
  std::string encoded(meshopt_encodeVertexBufferBound(count, stride), '\0');
  encoded.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(encoded.data()), encoded.size(),
                                            bytes.data(), count, stride));
  return encoded;
}

inline std::string MeshoptIndices(const std::vector<unsigned>& indices, bool triangles) {
  const std::size_t vertices = *std::max_element(indices.begin(), indices.end()) + 1;
  const std::size_t bound = triangles ? meshopt_encodeIndexBufferBound(indices.size(), vertices)
                                      : meshopt_encodeIndexSequenceBound(indices.size(), vertices);
  std::string encoded(bound, '\0');
  auto* to = reinterpret_cast<unsigned char*>(encoded.data());
  encoded.resize(triangles ? meshopt_encodeIndexBuffer(to, bound, indices.data(), indices.size())
                           : meshopt_encodeIndexSequence(to, bound, indices.data(), indices.size()));
  return encoded;
}

// Bytes behind those that the model's first buffer has; where.
inline std::size_t Append(Model& model, const std::string& bytes) {
  model.bin.resize((model.bin.size() + 3) / 4 * 4, '\0');
  const std::size_t at = model.bin.size();
  model.bin += bytes;
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  return at;
}

// Bufferview `view` holds `count` elements of `stride` bytes in `encoded`; as gltfpack writes it, its own buffer has no
// data.
inline void Compress(Model& model, std::size_t view, const std::string& encoded, std::size_t count, std::size_t stride,
                     const char* mode, const char* filter = nullptr, const char* extension = kMeshopt) {
  if (model.json["buffers"].size() == 1) {
    model.json["buffers"].push_back({{"byteLength", 1 << 20}, {"extensions", {{extension, {{"fallback", true}}}}}});
  }
  Json compressed = {{"buffer", 0},
                     {"byteOffset", Append(model, encoded)},
                     {"byteLength", encoded.size()},
                     {"byteStride", stride},
                     {"count", count},
                     {"mode", mode}};
  if (filter) compressed["filter"] = filter;
  Json& json = model.json["bufferViews"][view];
  json["buffer"] = 1;
  json["byteLength"] = count * stride;
  json["extensions"] = {{extension, compressed}};
  model.json["extensionsUsed"] = {extension};
  model.json["extensionsRequired"] = {extension};
}

// The tetrahedron, with nothing of it uncompressed.
inline Model MeshoptTetra(bool triangles = true, std::size_t index_stride = 2) {
  Model model = Tetra();
  const std::vector<std::uint16_t> indices = TetraIndices();
  model.bin.clear();
  Compress(model, 0, MeshoptVertices(Bytes(TetraPositions()), 12), 4, 12, "ATTRIBUTES");
  Compress(model, 1, MeshoptIndices({indices.begin(), indices.end()}, triangles), 12, index_stride,
           triangles ? "TRIANGLES" : "INDICES");
  model.json["accessors"][1]["componentType"] = index_stride == 2 ? 5123 : 5125;
  return model;
}

struct DracoAttribute {
  const char* name = "";  // of glTF
  draco::GeometryAttribute::Type type = draco::GeometryAttribute::GENERIC;
  draco::DataType data = draco::DT_FLOAT32;
  int width = 3;
  std::string bytes;
};

inline std::string EncodeDraco(const std::vector<std::array<std::uint32_t, 3>>& triangles, std::size_t vertices,
                               const std::vector<DracoAttribute>& attributes, bool edgebreaker, int position_bits = 0) {
  draco::Mesh mesh;
  mesh.SetNumFaces(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    draco::Mesh::Face face;
    for (std::size_t k = 0; k < 3; ++k) face[k] = draco::PointIndex(triangles[i][k]);
    mesh.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(i)), face);
  }
  mesh.set_num_points(static_cast<std::uint32_t>(vertices));
  for (const DracoAttribute& attribute : attributes) {
    draco::GeometryAttribute made;
    const std::int64_t stride = draco::DataTypeLength(attribute.data) * attribute.width;
    made.Init(attribute.type, nullptr, static_cast<std::uint8_t>(attribute.width), attribute.data, false, stride, 0);
    const int number = mesh.AddAttribute(made, true, static_cast<std::uint32_t>(vertices));
    for (std::size_t i = 0; i < vertices; ++i) {
      mesh.attribute(number)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(i)),
                                                &attribute.bytes[i * static_cast<std::size_t>(stride)]);
    }
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  if (position_bits > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) std::abort();
  return {buffer.data(), buffer.size()};
}

// Corners and vertices that a stream is decoded to: not all that was encoded has to be.
inline std::pair<std::size_t, std::size_t> DracoCounts(const std::string& encoded) {
  draco::DecoderBuffer buffer;
  buffer.Init(encoded.data(), encoded.size());
  const auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) std::abort();
  return {3 * decoded.value()->num_faces(), decoded.value()->num_points()};
}

// A primitive's data is `encoded`, and nothing of it plain any more; its attributes are numbered as listed.
inline void UseDraco(Model& model, const std::string& encoded, const std::vector<DracoAttribute>& attributes,
                     Json& primitive) {
  Json numbers = Json::object();
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    numbers[attributes[i].name] = i;
    model.json["accessors"][primitive["attributes"][attributes[i].name].get<std::size_t>()].erase("bufferView");
  }
  model.json["accessors"][primitive["indices"].get<std::size_t>()].erase("bufferView");
  model.json["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", Append(model, encoded)}, {"byteLength", encoded.size()}});
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", model.json["bufferViews"].size() - 1},
                                                           {"attributes", numbers}};
  model.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  model.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
}

inline void UseDraco(Model& model, const std::string& encoded, const std::vector<DracoAttribute>& attributes) {
  UseDraco(model, encoded, attributes, model.json["meshes"][0]["primitives"][0]);
}

inline DracoAttribute TetraDracoPositions() {
  return {"POSITION", draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, Bytes(TetraPositions())};
}

inline std::vector<std::array<std::uint32_t, 3>> TetraTriangles() {
  return {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
}

inline Model DracoTetra(bool edgebreaker, int position_bits = 0) {
  Model model = Tetra();
  model.bin.clear();
  UseDraco(model, EncodeDraco(TetraTriangles(), 4, {TetraDracoPositions()}, edgebreaker, position_bits),
           {TetraDracoPositions()});
  return model;
}

}  // namespace omni::scene::test
