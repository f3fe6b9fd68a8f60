#include "service/scene/gltf/node_tree.h"

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

// X = T R S, or the matrix as it stands (column-major)   [glTF 2.0, 3.5.3]
glm::dmat4 LocalTransform(const Json& node, const std::string& pointer) {
  if (const auto m = ReadNumberArray(node, pointer, "matrix", 16); !m.empty()) return glm::make_mat4(m.data());
  glm::dmat4 X(1.0);
  if (const auto t = ReadNumberArray(node, pointer, "translation", 3); !t.empty())
    X[3] = glm::dvec4(t[0], t[1], t[2], 1);
  if (const auto q = ReadNumberArray(node, pointer, "rotation", 4); !q.empty()) {
    const glm::dquat rotation(q[3], q[0], q[1], q[2]);
    const double length = glm::length(rotation);
    if (!(length > 1e-6))
      throw LoadError(JoinPointer(pointer, "rotation"), "is zero, must be a unit quaternion x, y, z, w");
    X = X * glm::mat4_cast(rotation / length);
  }
  if (const auto s = ReadNumberArray(node, pointer, "scale", 3); !s.empty()) {
    X[0] *= s[0];
    X[1] *= s[1];
    X[2] *= s[2];
  }
  return X;
}

bool Visible(const Json& node, const std::string& pointer) {
  constexpr const char* kVisibility = "KHR_node_visibility";
  const Json* extensions = FindObject(node, pointer, "extensions");
  const std::string place = JoinPointer(pointer, "extensions");
  const Json* visibility = extensions ? FindObject(*extensions, place, kVisibility) : nullptr;
  const Json* visible = visibility ? FindMember(*visibility, "visible") : nullptr;
  if (visible && !visible->is_boolean()) {
    throw LoadError(JoinPointer(JoinPointer(place, kVisibility), "visible"),
                    "is " + ValueText(*visible) + ", must be true or false");
  }
  return !visible || visible->boolean();
}

bool Finite(const glm::dmat4& X) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!(std::abs(X[column][row]) <= 1e30)) return false;
    }
  }
  return true;
}

std::vector<std::uint32_t> Indices(const Json& parent, const std::string& pointer, const char* key,
                                   std::uint64_t count) {
  std::vector<std::uint32_t> indices;
  const Json* array = FindArray(parent, pointer, key);
  if (!array) return indices;
  for (const Json& element : array->elements())
    indices.push_back(IndexIn(element, JoinPointer(JoinPointer(pointer, key), indices.size()), count));
  return indices;
}

class Walk {
 public:
  Walk(const Json& root, const LoadOptions& options, Warnings& warnings, const NamedTags* named)
      : root_(root),
        options_(options),
        warnings_(warnings),
        named_(named),
        count_(CountOf(root, "nodes")),
        seen_(count_, false) {}

  std::vector<NodeVisit> Run() {
    const std::vector<std::uint32_t> roots = Roots();
    const auto no_tag = std::make_shared<const HapticTag>();
    // (x, y, z) of a file whose z axis is up = (x, z, -y) of one whose y axis is.
    const glm::dmat4 upright =
        options_.z_up ? glm::dmat4(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1) : glm::dmat4(1);
    for (auto node = roots.rbegin(); node != roots.rend(); ++node) stack_.push_back({*node, 1, upright, no_tag, false});
    while (!stack_.empty()) {
      const Pending pending = stack_.back();
      stack_.pop_back();
      Visit(pending);
    }
    return std::move(visits_);
  }

 private:
  struct Pending {
    std::uint32_t node;
    std::uint32_t depth;
    glm::dmat4 parent_world;
    std::shared_ptr<const HapticTag> inherited;
    bool hidden;
  };

  std::vector<std::uint32_t> Roots() {
    if (count_ > options_.max_nodes) {
      throw LoadError("/nodes", "has " + std::to_string(count_) + " nodes, the limit is " +
                                    std::to_string(options_.max_nodes) + "; join meshes before exporting");
    }
    if (const std::uint64_t scenes = CountOf(root_, "scenes"); scenes > 0) {
      const std::uint32_t scene = ReadIndex(root_, "", "scene", scenes).value_or(0);
      return Indices(ElementOf(root_, "scenes", scene), JoinPointer("/scenes", scene), "nodes", count_);
    }
    std::vector<bool> is_child(count_, false);
    for (std::uint32_t node = 0; node < count_; ++node) {
      for (const std::uint32_t child : Children(node)) is_child[child] = true;
    }
    std::vector<std::uint32_t> roots;
    for (std::uint32_t node = 0; node < count_; ++node) {
      if (!is_child[node]) roots.push_back(node);
    }
    if (roots.empty() && count_ > 0)
      throw LoadError("/nodes", "has no root: every node is a child of another, in a circle");
    return roots;
  }

  std::vector<std::uint32_t> Children(std::uint32_t node) {
    return Indices(ElementOf(root_, "nodes", node), JoinPointer("/nodes", node), "children", count_);
  }

  void Visit(const Pending& pending) {
    NodeVisit visit;
    visit.node = pending.node;
    visit.pointer = JoinPointer("/nodes", pending.node);
    if (seen_[pending.node]) {
      throw LoadError(visit.pointer,
                      "is reached twice: it is its own ancestor or has two parents; a node has one parent");
    }
    seen_[pending.node] = true;
    if (pending.depth > options_.max_depth) {
      throw LoadError(visit.pointer, "lies deeper than " + std::to_string(options_.max_depth) +
                                         " levels; flatten the hierarchy before exporting");
    }
    const Json& node = ElementOf(root_, "nodes", pending.node);
    visit.name = FindString(node, visit.pointer, "name", "node " + std::to_string(pending.node));
    visit.world = pending.parent_world * LocalTransform(node, visit.pointer);
    if (!Finite(visit.world)) throw LoadError(visit.pointer, "its transform, with its parents', is not finite");
    visit.mesh = ReadIndex(node, visit.pointer, "mesh", CountOf(root_, "meshes"));
    visit.skin = ReadIndex(node, visit.pointer, "skin", CountOf(root_, "skins"));
    visit.hidden = pending.hidden || !Visible(node, visit.pointer);
    visit.inherited = pending.inherited;
    HapticTag own = ReadExtras(node, visit.pointer, warnings_);
    if (named_ != nullptr) named_->OverrideNamed(node, own);
    if (own.present) {
      visit.own = std::make_shared<const HapticTag>(std::move(own));
      visit.inherited = visit.own;
      if (pending.inherited->present) {
        auto both = std::make_shared<HapticTag>(*pending.inherited);
        both->OverrideBy(*visit.own);
        visit.inherited = std::move(both);
      }
    }
    const std::vector<std::uint32_t> children = Children(pending.node);
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      stack_.push_back({*child, pending.depth + 1, visit.world, visit.inherited, visit.hidden});
    }
    visits_.push_back(std::move(visit));
  }

  const Json& root_;
  const LoadOptions& options_;
  Warnings& warnings_;
  const NamedTags* const named_;
  std::uint64_t count_;
  std::vector<bool> seen_;
  std::vector<Pending> stack_;
  std::vector<NodeVisit> visits_;
};

}  // namespace

std::vector<NodeVisit> WalkNodes(const Json& root, const LoadOptions& options, Warnings& warnings,
                                 const NamedTags* named) {
  return Walk(root, options, warnings, named).Run();
}

}  // namespace omni::scene
