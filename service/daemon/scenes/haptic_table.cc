// Describes an application's own scene, as rows for its client.
#include <algorithm>

#include "service/base/material.h"
#include "service/daemon/scenes/app_scenes.h"
#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/protocol/text.h"

namespace omni::daemon {
namespace {

template <class T>
void AppendBytes(const T& value, std::string& message) {
  message.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

bool Names(const std::vector<std::uint32_t>& objects, std::uint32_t object) {
  return std::find(objects.begin(), objects.end(), object) != objects.end();
}

std::uint32_t NodeFlagsOf(const haptics::Scene& scene, const haptics::LivePlan& plan, std::uint32_t object) {
  const std::uint32_t flags = scene.objects()[object].flags;
  const bool extrudes = std::any_of(scene.regions().begin(), scene.regions().end(),
                                    [object](const haptics::Region& region) { return region.object == object; });
  return ((flags & haptics::kKinematic) != 0 ? protocol::kNodeKinematic : 0U) |
         ((flags & haptics::kDoubleSided) != 0 ? protocol::kNodeDoubleSided : 0U) |
         (Names(plan.soft, object) ? protocol::kNodeSoft : 0U) |
         (Names(plan.sculpted, object) ? protocol::kNodeSculptable : 0U) | (extrudes ? protocol::kNodeExtrudable : 0U);
}

protocol::HapticNodeRow NodeRowOf(const BuiltScene& built, const haptics::LivePlan& plan, std::uint32_t object) {
  const haptics::Object& from = built.scene->objects()[object];
  protocol::HapticNodeRow row;
  row.flags = NodeFlagsOf(*built.scene, plan, object);
  row.triangle_count = from.triangle_count;
  row.material = from.triangle_count > 0 ? haptics::MainMaterial(*built.scene, from) : 0;
  protocol::SetField(row.name, from.name);
  if (object < built.load.objects.size()) {
    const scene::ObjectSource& source = built.load.objects[object];
    row.gltf_node = source.node;
    row.rest_rotation_wxyz = source.rest_rotation_wxyz;
    row.rest_position_m = source.rest_position_m;
  }
  return row;
}

}  // namespace

std::string HapticTableMessage(std::uint32_t number, const BuiltScene& built) {
  protocol::HapticSceneTable table;
  table.number = number;
  const haptics::Scene& scene = *built.scene;
  if (!scene.empty()) {
    table.node_count = static_cast<std::uint32_t>(scene.objects().size());
    table.material_count = std::min<std::uint32_t>(scene.header().material_count, protocol::kMaxHapticMaterials);
  }
  std::string message;
  table.header.size = static_cast<std::uint32_t>(sizeof(table) + table.node_count * sizeof(protocol::HapticNodeRow) +
                                                 table.material_count * sizeof(base::MaterialParameters));
  AppendBytes(table, message);
  const haptics::LivePlan plan = scene.empty() ? haptics::LivePlan{} : haptics::PlanLive(scene);
  for (std::uint32_t i = 0; i < table.node_count; ++i) AppendBytes(NodeRowOf(built, plan, i), message);
  for (std::uint32_t i = 0; i < table.material_count; ++i)
    AppendBytes(base::Clamped(base::ParametersOf(scene.materials()[i])), message);
  return message;
}

}  // namespace omni::daemon
