#include "service/scene/join_objects.h"

#include <iterator>
#include <limits>
#include <map>
#include <tuple>

#include "service/haptics/scene/scene.h"

namespace omni::scene {
namespace {

// One set of coordinates, for `triangles` triangles.
void Pad(std::vector<haptics::CornerUv>& set, std::size_t triangles) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  set.resize(triangles, {kNone, kNone, kNone, kNone, kNone, kNone});
}

}  // namespace

void JoinTo(haptics::InputObject part, haptics::InputObject& whole) {
  for (std::size_t set = 0; set < haptics::kMaxUvSets; ++set) {
    if (part.uv[set].empty() && whole.uv[set].empty()) continue;
    Pad(whole.uv[set], whole.triangles.size());
    Pad(part.uv[set], part.triangles.size());
    whole.uv[set].insert(whole.uv[set].end(), part.uv[set].begin(), part.uv[set].end());
  }
  const auto first = static_cast<std::uint32_t>(whole.vertices_base_m.size());
  whole.vertices_base_m.insert(whole.vertices_base_m.end(), part.vertices_base_m.begin(), part.vertices_base_m.end());
  for (const auto& [a, b, c] : part.triangles) whole.triangles.push_back({first + a, first + b, first + c});
  whole.triangle_material.insert(whole.triangle_material.end(), part.triangle_material.begin(),
                                 part.triangle_material.end());
}

bool JoinBeyondLimit(std::vector<haptics::InputObject>& objects) {
  if (objects.size() <= haptics::kMaxObjects) return false;
  std::vector<haptics::InputObject> kept(std::make_move_iterator(objects.begin()),
                                         std::make_move_iterator(objects.begin() + kKeptApart));
  std::map<std::tuple<bool, bool, bool>, haptics::InputObject> joined;
  for (std::size_t i = kept.size(); i < objects.size(); ++i) {
    haptics::InputObject& from = objects[i];
    haptics::InputObject& to = joined[{from.double_sided, from.car_wall, from.kinematic}];
    if (to.name.empty()) {
      to.name = from.name + " and others";
      to.source = from.source;
    }
    to.double_sided = from.double_sided;
    to.car_wall = from.car_wall;
    to.kinematic = from.kinematic;
    JoinTo(std::move(from), to);
  }
  for (auto& [kind, object] : joined) kept.push_back(std::move(object));
  objects = std::move(kept);
  return true;
}

}  // namespace omni::scene
