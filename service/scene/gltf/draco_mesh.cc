#include "service/scene/gltf/draco_mesh.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

namespace omni::scene {

struct DracoMesh::Decoded {
  std::unique_ptr<draco::Mesh> mesh;
};

namespace {

// The bitstream that the extension allows.
constexpr unsigned char kMajor = 2, kMinor = 2;
constexpr unsigned char kIsMesh = 1;
constexpr unsigned char kSequential = 0, kEdgebreaker = 1;
constexpr std::uint16_t kHasMetadata = 0x8000;

// While it is decoded, half of what a corner and a vertex take, and more for each of their attributes. Measured: 155
// bytes for each vertex of a closed mesh with positions only, 400 with five attributes.
constexpr std::uint64_t kCornerBytes = 8, kCornerAttributeBytes = 4;
constexpr std::uint64_t kVertexBytes = 24, kVertexAttributeBytes = 24;

struct Counts {
  std::uint32_t triangles = 0, vertices = 0;  // fewer vertices than in the end, where attributes have seams
  unsigned char seams = 0;                    // tables of corners besides that of positions, one for each attribute
  bool sequential = false;
};

// Knows before it decodes any attribute how large all are: a stream of a few bytes can hold as many and as wide ones as
// it likes.
template <class Decoder>
class Bounded : public Decoder {
 public:
  explicit Bounded(std::uint64_t most_bytes) : most_bytes_(most_bytes) {}
  bool exceeded() const { return exceeded_; }

 protected:
  bool DecodeAllAttributes() override {
    std::uint64_t bytes = 0;
    const draco::Mesh& mesh = *this->mesh();
    for (int i = 0; i < mesh.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *mesh.attribute(i);
      bytes += std::uint64_t{mesh.num_points()} * attribute.num_components() *
               static_cast<std::uint64_t>(std::max(4, draco::DataTypeLength(attribute.data_type())));
    }
    exceeded_ = bytes > most_bytes_;
    return !exceeded_ && Decoder::DecodeAllAttributes();
  }

 private:
  const std::uint64_t most_bytes_;
  bool exceeded_ = false;
};

// The head of a stream: what the library would allocate memory for.
std::optional<Counts> HeadOf(std::span<const unsigned char> stored) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stored.data()), stored.size());
  char magic[5]{};
  unsigned char major = 0, minor = 0, type = 0, method = 0, traversal = 0;
  std::uint16_t flags = 0;
  const bool read = buffer.Decode(magic, sizeof magic) && buffer.Decode(&major) && buffer.Decode(&minor) &&
                    buffer.Decode(&type) && buffer.Decode(&method) && buffer.Decode(&flags);
  if (!read || std::string_view(magic, sizeof magic) != "DRACO" || major != kMajor || minor != kMinor ||
      type != kIsMesh || method > kEdgebreaker) {
    return std::nullopt;
  }
  buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(kMajor, kMinor));
  draco::GeometryMetadata metadata;
  if ((flags & kHasMetadata) != 0 && !draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata))
    return std::nullopt;
  Counts counts{.sequential = method == kSequential};
  const bool counted =
      counts.sequential
          ? draco::DecodeVarint(&counts.triangles, &buffer) && draco::DecodeVarint(&counts.vertices, &buffer)
          : buffer.Decode(&traversal) && draco::DecodeVarint(&counts.vertices, &buffer) &&
                draco::DecodeVarint(&counts.triangles, &buffer) && buffer.Decode(&counts.seams);
  return counted ? std::optional(counts) : std::nullopt;
}

std::string TextOf(std::uint64_t triangles, std::uint64_t vertices) {
  return std::to_string(triangles) + " triangles and " + std::to_string(vertices) + " vertices";
}

std::optional<std::uint64_t> ComponentOf(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 5120;
    case draco::DT_UINT8:
      return 5121;
    case draco::DT_INT16:
      return 5122;
    case draco::DT_UINT16:
      return 5123;
    case draco::DT_UINT32:
      return 5125;
    case draco::DT_FLOAT32:
      return 5126;
    default:
      return std::nullopt;
  }
}

}  // namespace

DracoMesh::DracoMesh(const std::string& pointer, std::span<const unsigned char> stored, std::uint64_t triangles,
                     std::uint64_t vertices, std::uint64_t most_bytes)
    : decoded_(std::make_unique<Decoded>()), triangles_(triangles), vertices_(vertices) {
  constexpr const char* kRemedy = "; export again, without mesh compression if that does not help";
  const std::optional<Counts> head = HeadOf(stored);
  if (!head) throw LoadError(pointer, std::string("its data is no Draco mesh of version 2.2") + kRemedy);
  const auto mismatch = [&](std::uint64_t faces, std::uint64_t points) {
    return LoadError(pointer, "its data has " + TextOf(faces, points) + ", its accessors have " +
                                  TextOf(triangles, vertices) + kRemedy);
  };
  if (head->triangles != triangles || (head->sequential ? head->vertices != vertices : head->vertices > vertices))
    throw mismatch(head->triangles, head->vertices);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stored.data()), stored.size());
  decoded_->mesh = std::make_unique<draco::Mesh>();
  bool exceeded = head->seams * 3 * kCornerAttributeBytes * triangles > most_bytes;
  const auto decode = [&](auto decoder) {
    const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, decoded_->mesh.get());
    exceeded = decoder.exceeded();
    if (!exceeded && !status.ok())
      throw LoadError(pointer, "its data cannot be decoded (" + status.error_msg_string() + ")" + kRemedy);
  };
  if (!exceeded && head->sequential) decode(Bounded<draco::MeshSequentialDecoder>(most_bytes));
  if (!exceeded && !head->sequential) decode(Bounded<draco::MeshEdgebreakerDecoder>(most_bytes));
  if (exceeded) {
    throw LoadError(pointer, "its attributes, also those that are not read, are decoded to more than " +
                                 std::to_string(most_bytes) + " bytes; export again without them");
  }
  if (decoded_->mesh->num_faces() != triangles || decoded_->mesh->num_points() != vertices)
    throw mismatch(decoded_->mesh->num_faces(), decoded_->mesh->num_points());
}

DracoMesh::~DracoMesh() = default;

void DracoMesh::CopyCorners(unsigned char* to) const {
  for (draco::FaceIndex face(0); face < decoded_->mesh->num_faces(); ++face) {
    for (const draco::PointIndex& corner : decoded_->mesh->face(face)) {
      const std::uint32_t vertex = corner.value();
      std::memcpy(to, &vertex, sizeof vertex);
      to += sizeof vertex;
    }
  }
}

std::optional<DracoMesh::Attribute> DracoMesh::Find(std::uint32_t number) const {
  const draco::PointAttribute* attribute = decoded_->mesh->GetAttributeByUniqueId(number);
  const std::optional<std::uint64_t> component = attribute ? ComponentOf(attribute->data_type()) : std::nullopt;
  if (!component) return std::nullopt;
  return Attribute{*component, attribute->num_components()};
}

void DracoMesh::CopyAttribute(std::uint32_t number, unsigned char* to) const {
  const draco::PointAttribute& attribute = *decoded_->mesh->GetAttributeByUniqueId(number);
  const std::size_t bytes = static_cast<std::size_t>(draco::DataTypeLength(attribute.data_type())) *
                            static_cast<std::size_t>(attribute.num_components());
  for (draco::PointIndex point(0); point < decoded_->mesh->num_points(); ++point) {
    const draco::AttributeValueIndex value = attribute.mapped_index(point);
    std::memset(to, 0, bytes);
    if (value.value() < attribute.size()) std::memcpy(to, attribute.GetAddress(value), bytes);
    to += bytes;
  }
}

std::uint64_t DracoBytes(const Json& root, std::uint32_t mesh) {
  const std::uint64_t accessors = CountOf(root, "accessors");
  const auto count_of = [&](const Json* index) {
    const std::uint64_t accessor = index ? index->whole().value_or(accessors) : accessors;
    const Json* count = accessor < accessors ? FindMember(ElementOf(root, "accessors", accessor), "count") : nullptr;
    return std::min<std::uint64_t>(count ? count->whole().value_or(0) : 0, 1ull << 32);
  };
  std::uint64_t bytes = 0;
  const Json* primitives = FindMember(ElementOf(root, "meshes", mesh), "primitives");
  for (const Json& primitive : primitives ? primitives->elements() : std::span<const Json>()) {
    const Json* extensions = FindMember(primitive, "extensions");
    const Json* compressed = extensions ? FindMember(*extensions, kDracoExtension) : nullptr;
    if (!compressed) continue;
    const Json* attributes = FindMember(primitive, "attributes");
    const Json* stored = FindMember(*compressed, "attributes");
    const std::uint64_t of_each = stored ? stored->members().size() : 0;
    bytes += count_of(FindMember(primitive, "indices")) * (kCornerBytes + of_each * kCornerAttributeBytes) +
             count_of(attributes ? FindMember(*attributes, "POSITION") : nullptr) *
                 (kVertexBytes + of_each * kVertexAttributeBytes);
  }
  return std::min<std::uint64_t>(bytes, 1ull << 40);
}

}  // namespace omni::scene
