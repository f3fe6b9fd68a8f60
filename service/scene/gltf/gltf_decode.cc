#include "service/scene/gltf/gltf_decode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/gltf_subset.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

constexpr std::uint32_t kUnused = 0xFFFFFFFF;

template <class T>
T Load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

// Component -> number; normalised integers: max(c / (2^(b-1) - 1), -1) and c / (2^b - 1)   [glTF 2.0, 3.6.2.2]
double Component(const unsigned char* bytes, std::uint64_t type, bool normalized) {
  switch (type) {
    case 5120:
      return normalized ? std::max(Load<std::int8_t>(bytes) / 127.0, -1.0) : Load<std::int8_t>(bytes);
    case 5121:
      return normalized ? *bytes / 255.0 : *bytes;
    case 5122:
      return normalized ? std::max(Load<std::int16_t>(bytes) / 32767.0, -1.0) : Load<std::int16_t>(bytes);
    case 5123:
      return normalized ? Load<std::uint16_t>(bytes) / 65535.0 : Load<std::uint16_t>(bytes);
    case 5125:
      return Load<std::uint32_t>(bytes);
    default:
      return static_cast<double>(Load<float>(bytes));
  }
}

// Elements of an accessor as rows of numbers, each decoded on demand: an accessor may have a million elements and a
// primitive use three. Its ranges were checked when the subset was built.
class Elements {
 public:
  using Row = std::array<double, 4>;
  using Matrix = std::array<double, 16>;

  Elements(const Subset& subset, std::size_t index) : accessor_(subset.accessors.at(index)), bytes_(subset.bytes) {
    const std::size_t index_bytes = accessor_.changed > 0 ? ComponentBytes(accessor_.index_component) : 0;
    replaced_.reserve(accessor_.changed);
    for (std::size_t i = 0; i < accessor_.changed; ++i) {
      const unsigned char* at = bytes_.data() + accessor_.index_offset + i * index_bytes;
      const auto element = static_cast<std::size_t>(Component(at, accessor_.index_component, false));
      if (element >= accessor_.count) {
        throw LoadError("/accessors", "sparse index " + std::to_string(element) + " is beyond the accessor's " +
                                          std::to_string(accessor_.count) + " elements");
      }
      replaced_.emplace_back(element, i);
    }
    std::sort(replaced_.begin(), replaced_.end());
  }

  std::size_t count() const { return accessor_.count; }
  std::size_t width() const { return accessor_.width; }

  Row operator[](std::size_t i) const { return At<Row>(i); }

  template <class R>
  R At(std::size_t i) const {
    const std::size_t bytes = ComponentBytes(accessor_.component);
    std::size_t at = accessor_.offset + i * accessor_.stride;
    bool zero = accessor_.zeros;
    // Of several that replace it, the last.
    const auto after = std::upper_bound(replaced_.begin(), replaced_.end(), std::pair(i, accessor_.changed));
    if (after != replaced_.begin() && std::prev(after)->first == i) {
      at = accessor_.value_offset + std::prev(after)->second * bytes * accessor_.width;
      zero = false;
    }
    R row{};
    for (std::size_t c = 0; !zero && c < accessor_.width; ++c)
      row[c] = Component(bytes_.data() + at + c * bytes, accessor_.component, accessor_.normalized);
    return row;
  }

 private:
  const SubsetAccessor& accessor_;
  const std::vector<unsigned char>& bytes_;
  std::vector<std::pair<std::size_t, std::size_t>> replaced_;  // element, its place among the sparse values; sorted
};

// Corner numbers of a primitive, three per triangle   [glTF 2.0, 3.7.2.1: strips alternate their winding]
std::vector<std::uint32_t> Corners(const std::vector<std::uint32_t>& run, std::uint64_t mode) {
  std::vector<std::uint32_t> corners;
  const std::size_t n = run.size();
  if (mode == 4) return {run.begin(), run.begin() + static_cast<std::ptrdiff_t>(n / 3 * 3)};
  for (std::size_t i = 0; i + 2 < n; ++i) {
    if (mode == 5) {
      corners.insert(corners.end(), {run[i], run[i + 1 + i % 2], run[i + 2 - i % 2]});
    } else {
      corners.insert(corners.end(), {run[i + 1], run[i + 2], run[0]});
    }
  }
  return corners;
}

// Three corners of each triangle from a table of the vertices.
std::vector<haptics::CornerUv> CornerUvs(const Elements& uv, const std::vector<std::uint32_t>& corners) {
  std::vector<haptics::CornerUv> triangles(corners.size() / 3);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Elements::Row row = uv[corners[i]];
    for (std::size_t c = 0; c < 2; ++c) triangles[i / 3][2 * (i % 3) + c] = static_cast<float>(row[c]);
  }
  return triangles;
}

// The first three components at the vertices that are kept.
std::vector<base::Vec3> Kept(const Elements& elements, const std::vector<std::uint32_t>& vertices) {
  std::vector<base::Vec3> values;
  values.reserve(vertices.size());
  for (const std::uint32_t vertex : vertices) {
    const Elements::Row v = elements[vertex];
    values.push_back({v[0], v[1], v[2]});
  }
  return values;
}

// A joint of a skin: how it moves what it holds.
struct Joint {
  glm::dmat4 placed{1.0};  // mesh -> scene, with the mesh as it was bound
  double scale = 1;        // at most, of lengths
};

double LargestScale(const glm::dmat4& X) {
  const glm::dmat3 axes(X);
  return std::max({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
}

// The cost depends on the primitive's triangles, not on the vertices that only others use.
class Decoder {
 public:
  Decoder(const Subset& subset, const base::WorkWatch& watch) : subset_(subset), watch_(watch) {}

  DecodedPrimitive Decode(const SubsetPrimitive& primitive) {
    const Elements& positions = ElementsOf(primitive.positions);
    const std::vector<std::uint32_t> corners = Corners(VertexRun(primitive, positions.count()), primitive.mode);
    DecodedPrimitive decoded;
    std::vector<std::uint32_t> kept;  // vertices, in the order of decoded.positions
    double largest = 0;               // stored coordinate
    std::vector<Weighted> morph;
    for (const auto& [accessor, weight] : primitive.morph) morph.emplace_back(&ElementsOf(accessor), weight);
    if (numbers_.size() < positions.count()) numbers_.resize(positions.count(), kUnused);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      watch_.Did();
      std::uint32_t& number = numbers_[corners[i]];
      if (number == kUnused) {
        number = static_cast<std::uint32_t>(decoded.positions.size());
        decoded.positions.push_back(Position(positions, morph, corners[i], primitive, largest));
        kept.push_back(corners[i]);
      }
      if (i % 3 == 0) decoded.triangles.emplace_back();
      decoded.triangles.back()[i % 3] = number;
    }
    for (const std::uint32_t vertex : kept) numbers_[vertex] = kUnused;
    if (subset_.accessors[primitive.positions].component == 5126) {
      const auto stored = static_cast<float>(largest);
      decoded.float_reach = largest;
      decoded.float_step =
          static_cast<double>(std::nextafter(stored, std::numeric_limits<float>::infinity())) - largest;
    }
    if (primitive.skin) Pose(primitive, kept, decoded);
    if (primitive.normals) decoded.normals = Kept(ElementsOf(*primitive.normals), kept);
    if (primitive.colours) decoded.colours = Kept(ElementsOf(*primitive.colours), kept);
    for (std::size_t set = 0; set < haptics::kMaxUvSets; ++set) {
      if ((primitive.uv_sets >> set & 1) != 0) decoded.uv[set] = CornerUvs(ElementsOf(primitive.uv[set]), corners);
    }
    return decoded;
  }

  std::vector<Instance> DecodeInstances(const SubsetInstances& from) {
    std::vector<Instance> instances(static_cast<std::size_t>(from.count));
    const auto fill = [&](const std::optional<std::size_t>& accessor, auto Instance::*field) {
      if (!accessor) return;
      const Elements& elements = ElementsOf(*accessor);
      for (std::size_t i = 0; i < instances.size(); ++i) {
        const Elements::Row row = elements[i];
        for (std::size_t c = 0; c < elements.width(); ++c) {
          if (!(std::abs(row[c]) <= 1e12)) {
            throw LoadError("/nodes/" + std::to_string(from.node) + "/extensions/EXT_mesh_gpu_instancing",
                            "instance " + std::to_string(i) + " is not finite");
          }
          (instances[i].*field)[c] = row[c];
        }
      }
    };
    fill(from.translation, &Instance::translation);
    fill(from.rotation, &Instance::rotation);
    fill(from.scale, &Instance::scale);
    return instances;
  }

 private:
  using Weighted = std::pair<const Elements*, double>;
  using Influences = std::vector<std::pair<const Elements*, const Elements*>>;  // joints, weights

  const Elements& ElementsOf(std::size_t accessor) {
    return elements_.try_emplace(accessor, subset_, accessor).first->second;
  }

  std::vector<std::uint32_t> VertexRun(const SubsetPrimitive& primitive, std::size_t vertices) {
    if (!primitive.indices) {
      std::vector<std::uint32_t> all(vertices);
      std::iota(all.begin(), all.end(), 0U);
      return all;
    }
    const Elements& indices = ElementsOf(*primitive.indices);
    std::vector<std::uint32_t> run;
    run.reserve(indices.count());
    for (std::size_t i = 0; i < indices.count(); ++i) {
      watch_.Did();
      const double index = indices[i][0];
      if (!(index < static_cast<double>(vertices))) {
        throw LoadError(primitive.pointer + "/indices", "index " + std::to_string(i) + " names vertex " +
                                                            std::to_string(static_cast<std::uint64_t>(index)) + " of " +
                                                            std::to_string(vertices) + "; export the file again");
      }
      run.push_back(static_cast<std::uint32_t>(index));
    }
    return run;
  }

  // p + sum w_k d_k   [glTF 2.0, 3.7.2.2]
  static base::Vec3 Position(const Elements& positions, const std::vector<Weighted>& morph, std::uint32_t vertex,
                             const SubsetPrimitive& primitive, double& largest) {
    Elements::Row p = positions[vertex];
    for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(p[c]));
    for (const auto& [displacements, weight] : morph) {
      const Elements::Row moved = (*displacements)[vertex];
      for (std::size_t c = 0; c < 3; ++c) p[c] += weight * moved[c];
    }
    if (!(std::abs(p[0]) <= 1e12 && std::abs(p[1]) <= 1e12 && std::abs(p[2]) <= 1e12)) {
      throw LoadError("/accessors/" + std::to_string(primitive.accessor),
                      "vertex " + std::to_string(vertex) + " is not finite or beyond 1e12 m; repair the model");
    }
    return {p[0], p[1], p[2]};
  }

  // Joint transforms times inverse bind matrices, once per skin   [glTF 2.0, 3.7.3.3]
  const std::vector<Joint>& JointsOf(std::size_t number) {
    const auto [place, fresh] = joints_.try_emplace(number);
    if (!fresh) return place->second;
    const SubsetSkin& skin = subset_.skins[number];
    const Elements* inverse = skin.inverse_bind ? &ElementsOf(*skin.inverse_bind) : nullptr;
    place->second.reserve(skin.from.joints.size());
    for (std::size_t i = 0; i < skin.from.joints.size(); ++i) {
      Joint joint{.placed = skin.from.joints[i]};
      if (inverse != nullptr) joint.placed *= glm::make_mat4(inverse->At<Elements::Matrix>(i).data());
      joint.scale = LargestScale(joint.placed);
      if (!(joint.scale <= 1e30 && glm::length(joint.placed[3]) <= 1e30)) {
        throw LoadError("/skins/" + std::to_string(skin.from.skin) + "/inverseBindMatrices",
                        "matrix " + std::to_string(i) + ", with its joint's transform, is not finite");
      }
      place->second.push_back(joint);
    }
    return place->second;
  }

  // Where the joints of the vertices place them: the node's own transform has no influence.
  void Pose(const SubsetPrimitive& primitive, const std::vector<std::uint32_t>& kept, DecodedPrimitive& decoded) {
    const std::vector<Joint>& joints = JointsOf(*primitive.skin);
    Influences influences;
    for (const auto& [numbers, weights] : primitive.influences)
      influences.emplace_back(&ElementsOf(numbers), &ElementsOf(weights));
    double largest_scale = 0;
    std::ptrdiff_t turned = 0;  // more vertices mirrored than not
    for (std::size_t i = 0; i < kept.size(); ++i) {
      watch_.Did();
      const glm::dmat4 placed = Blend(primitive, influences, kept[i], joints, largest_scale);
      base::Vec3& p = decoded.positions[i];
      const glm::dvec4 posed = placed * glm::dvec4(p.x, p.y, p.z, 1);
      p = {posed.x, posed.y, posed.z};
      turned += glm::determinant(glm::dmat3(placed)) < 0 ? 1 : -1;
    }
    decoded.placed = true;
    decoded.mirrored = turned > 0;
    decoded.float_step *= largest_scale;
    decoded.float_reach *= largest_scale;
  }

  // Weights need not have a sum of 1; a vertex without any is held by its first joint.
  static glm::dmat4 Blend(const SubsetPrimitive& primitive, const Influences& influences, std::uint32_t vertex,
                          const std::vector<Joint>& joints, double& largest_scale) {
    glm::dmat4 blend(0.0);
    double sum = 0;
    const auto add = [&](double joint, double weight, std::size_t set) {
      if (!(joint < static_cast<double>(joints.size()))) {
        throw LoadError(primitive.pointer + "/attributes/JOINTS_" + std::to_string(set),
                        "vertex " + std::to_string(vertex) + " names joint " +
                            std::to_string(static_cast<std::uint64_t>(joint)) + " of " + std::to_string(joints.size()) +
                            "; export the file again");
      }
      const Joint& held_by = joints[static_cast<std::size_t>(joint)];
      blend += weight * held_by.placed;
      sum += weight;
      largest_scale = std::max(largest_scale, held_by.scale);
    };
    for (std::size_t set = 0; set < influences.size(); ++set) {
      const Elements::Row numbers = (*influences[set].first)[vertex], weights = (*influences[set].second)[vertex];
      for (std::size_t c = 0; c < 4; ++c) {
        if (!(weights[c] >= 0 && weights[c] <= 1e6)) {
          throw LoadError(primitive.pointer + "/attributes/WEIGHTS_" + std::to_string(set),
                          "vertex " + std::to_string(vertex) + " has a weight that is negative or not finite");
        }
        if (weights[c] > 0) add(numbers[c], weights[c], set);
      }
    }
    if (sum == 0) add((*influences[0].first)[vertex][0], 1, 0);
    return blend / sum;
  }

  const Subset& subset_;
  const base::WorkWatch& watch_;
  std::map<std::size_t, Elements> elements_;          // by accessor
  std::map<std::size_t, std::vector<Joint>> joints_;  // by skin
  std::vector<std::uint32_t> numbers_;  // of the present primitive's vertices; kUnused between two of them
};

}  // namespace

DecodedSubset DecodeSubset(const Subset& subset, const base::WorkWatch& watch) {
  DecodedSubset decoded;
  Decoder decoder(subset, watch);
  std::size_t triangles = 0;
  for (const SubsetPrimitive& primitive : subset.primitives) {
    if (!primitive.skipped.empty()) continue;
    decoded.primitives.push_back(decoder.Decode(primitive));
    triangles += decoded.primitives.back().triangles.size();
    if (triangles > haptics::kMaxTriangles) {
      throw LoadError(primitive.pointer, "with those before, has more than " + std::to_string(haptics::kMaxTriangles) +
                                             " triangles; simplify the model");
    }
  }
  for (const SubsetInstances& from : subset.instances) decoded.instances.push_back(decoder.DecodeInstances(from));
  return decoded;
}

}  // namespace omni::scene
