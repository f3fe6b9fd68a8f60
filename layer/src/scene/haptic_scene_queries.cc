// An application's queries about its scene.
#include <algorithm>
#include <cstring>

#include "layer/src/entry/two_call.h"
#include "layer/src/scene/haptic_scene.h"

namespace omni::layer {
namespace {

XrPosef RestPoseOf(const protocol::HapticNodeRow& row) noexcept {
  const auto& q = row.rest_rotation_wxyz;
  const auto& p = row.rest_position_m;
  return ToXr(Pose{{p[0], p[1], p[2]}, glm::dquat(q[0], q[1], q[2], q[3])});
}

struct FlagPair {
  std::uint32_t ours;
  XrHapticNodeFlagsOMNIX1 theirs;
};

XrHapticNodeFlagsOMNIX1 NodeFlags(std::uint32_t flags) noexcept {
  XrHapticNodeFlagsOMNIX1 out = 0;
  for (const FlagPair& pair : {FlagPair{protocol::kNodeKinematic, XR_HAPTIC_NODE_KINEMATIC_BIT_OMNIX1},
                               FlagPair{protocol::kNodeSoft, XR_HAPTIC_NODE_SOFT_BIT_OMNIX1},
                               FlagPair{protocol::kNodeSculptable, XR_HAPTIC_NODE_SCULPTABLE_BIT_OMNIX1},
                               FlagPair{protocol::kNodeExtrudable, XR_HAPTIC_NODE_EXTRUDABLE_BIT_OMNIX1},
                               FlagPair{protocol::kNodeDoubleSided, XR_HAPTIC_NODE_DOUBLE_SIDED_BIT_OMNIX1}}) {
    if ((flags & pair.ours) != 0) out |= pair.theirs;
  }
  return out;
}

glm::dvec3 ToVector(const std::array<double, 3>& v) noexcept { return {v[0], v[1], v[2]}; }

constexpr std::uint32_t kChangesShape = protocol::kNodeSoft | protocol::kNodeSculptable | protocol::kNodeExtrudable;

// The two-call idiom for an array of the application's structures, all of which must have this type.
template <class T, class Write>
XrResult FillTyped(XrStructureType type, std::size_t n, uint32_t capacity, uint32_t* count, T* out, Write write) {
  const XrResult result = CheckCapacity(n, capacity, count, out);
  if (result != XR_SUCCESS || capacity == 0) return result;
  if (std::any_of(out, out + n, [type](const T& one) { return one.type != type; })) return XR_ERROR_VALIDATION_FAILURE;
  for (std::size_t i = 0; i < n; ++i) write(i, out[i]);
  return XR_SUCCESS;
}

// The same for one of two arrays. False: there is room, but not enough.
bool Fits(std::uint32_t capacity, std::uint32_t count) noexcept { return capacity == 0 || capacity >= count; }

// What the tick has published last of an object. False: nothing yet.
bool ReadSurface(const client::SurfaceReader& reader, std::uint32_t object, client::SurfaceCopy& copy) {
  for (std::size_t i = 0; i < reader.object_count(); ++i) {
    if (reader.object(i).object == object && reader.Read(i, copy) != client::SurfaceRead::kNothing)
      return copy.frame.t_ns > 0;
  }
  return false;
}

// The sizes, and the arrays where there is room for them.
XrResult Put(const client::SurfaceCopy& copy, double scale, XrHapticNodeMeshOMNIX1& mesh) {
  const auto vertex_count = static_cast<uint32_t>(copy.vertices_base_m.size());
  const auto index_count = static_cast<uint32_t>(3 * copy.triangles.size());
  mesh.vertexCountOutput = vertex_count;
  mesh.indexCountOutput = index_count;
  const bool fits = Fits(mesh.vertexCapacityInput, vertex_count) && Fits(mesh.indexCapacityInput, index_count);
  if (!fits) return XR_ERROR_SIZE_INSUFFICIENT;
  mesh.vertexChange = copy.frame.vertex_change;
  mesh.indexChange = copy.frame.triangle_change;
  mesh.maxDisplacement = static_cast<float>(copy.frame.largest_displacement_m / scale);
  if (!fits) return XR_ERROR_SIZE_INSUFFICIENT;
  const auto per_scale = static_cast<float>(1 / scale);
  if (mesh.vertexCapacityInput > 0) {
    // (x, y, z) of the service's frame of the scene, z up, is (x, z, -y) of the document's.
    std::transform(copy.vertices_base_m.begin(), copy.vertices_base_m.end(), mesh.vertices,
                   [per_scale](const protocol::SurfacePoint& p) {
                     return XrVector3f{per_scale * p[0], per_scale * p[2], -per_scale * p[1]};
                   });
  }
  if (mesh.indexCapacityInput > 0) {
    uint32_t* to = mesh.indices;
    for (const protocol::SurfaceTriangle& triangle : copy.triangles)
      to = std::copy(triangle.begin(), triangle.end(), to);
  }
  return XR_SUCCESS;
}

}  // namespace

XrResult HapticScenes::EnumerateNodes(XrHapticSceneOMNIX1 handle, uint32_t capacity, uint32_t* count,
                                      XrHapticSceneNodeOMNIX1* nodes) {
  if (!count || (capacity > 0 && !nodes)) return XR_ERROR_VALIDATION_FAILURE;
  Poll();
  return WithScene(handle, Need::kReady, [&](const HapticScene& scene) {
    const auto write = [&](std::size_t i, XrHapticSceneNodeOMNIX1& node) {
      const protocol::HapticNodeRow& row = scene.table.nodes[i];
      node.node = NodeIdOf(scene, static_cast<std::uint32_t>(i));
      node.gltfNode = row.gltf_node;
      node.flags = NodeFlags(row.flags);
      node.materialIndex = row.material;
      node.triangleCount = row.triangle_count;
      node.restPose = RestPoseOf(row);
      static_assert(sizeof(node.name) == sizeof(row.name));
      std::memcpy(node.name, row.name, sizeof(row.name));
    };
    return FillTyped(XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1, scene.table.nodes.size(), capacity, count, nodes, write);
  });
}

XrResult HapticScenes::GetMaterial(XrHapticSceneOMNIX1 handle, uint32_t index, XrHapticMaterialOMNIX1* out) {
  if (!out || out->type != XR_TYPE_HAPTIC_MATERIAL_OMNIX1) return XR_ERROR_VALIDATION_FAILURE;
  Poll();
  return WithScene(handle, Need::kReady, [&](const HapticScene& scene) {
    if (index >= scene.table.materials.size()) return XR_ERROR_INDEX_OUT_OF_RANGE;
    const auto changed = scene.changed.find(index);
    Put(changed != scene.changed.end() ? changed->second : scene.table.materials[index], *out);
    return XR_SUCCESS;
  });
}

XrResult HapticScenes::EnumerateContacts(XrHapticSceneOMNIX1 handle, const XrHapticContactsGetInfoOMNIX1* info,
                                         uint32_t capacity, uint32_t* count, XrHapticContactOMNIX1* contacts) {
  if (!info || info->type != XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1 || !count || (capacity > 0 && !contacts))
    return XR_ERROR_VALIDATION_FAILURE;
  if (info->time <= 0) return XR_ERROR_TIME_INVALID;
  Poll();
  Located X_OS;
  const XrResult located = Locate(handle, Need::kReady, info->baseSpace, info->time, X_OS);
  if (XR_FAILED(located)) return located;
  return WithScene(handle, Need::kHandle, [&](const HapticScene& scene) {
    const std::uint64_t generation = scene.state.generation;
    protocol::ContactSnapshot snapshot;
    const auto reader = link_.reader();
    const bool known = generation != 0 && (X_OS.flags & kValid) == kValid && reader && reader->ReadContacts(snapshot) &&
                       snapshot.scene_generation == generation;
    const Pose X_SO = Inverse(X_OS.motion.X);
    const auto write = [&](std::size_t i, XrHapticContactOMNIX1& contact) {
      const protocol::ContactSample& from = snapshot.contacts[i];
      contact.node =
          from.object < scene.table.nodes.size() ? NodeIdOf(scene, from.object) : XR_NULL_HAPTIC_NODE_ID_OMNIX1;
      contact.materialIndex = from.material;
      contact.point = ToXr(X_SO.p + X_SO.q * ToVector(from.point_base_m));
      contact.normal = ToXr(X_SO.q * ToVector(from.normal_base));
      contact.force = ToXr(X_SO.q * ToVector(from.force_base_N));
      contact.normalForce = static_cast<float>(from.normal_force_N);
      contact.tangentialForce = static_cast<float>(from.tangential_force_N);
      contact.penetration = static_cast<float>(from.penetration_m);
      contact.slipVelocity = ToXr(X_SO.q * ToVector(from.slip_base_m_s));
      contact.time = clock_.ToXr(snapshot.t_ns);
    };
    return FillTyped(XR_TYPE_HAPTIC_CONTACT_OMNIX1, known ? snapshot.count : 0, capacity, count, contacts, write);
  });
}

XrResult HapticScenes::GetNodeMesh(XrHapticSceneOMNIX1 handle, const XrHapticNodeMeshGetInfoOMNIX1* info,
                                   XrHapticNodeMeshOMNIX1* mesh) {
  if (!info || info->type != XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1 || !mesh ||
      mesh->type != XR_TYPE_HAPTIC_NODE_MESH_OMNIX1 || (mesh->vertexCapacityInput > 0 && !mesh->vertices) ||
      (mesh->indexCapacityInput > 0 && !mesh->indices)) {
    return XR_ERROR_VALIDATION_FAILURE;
  }
  Poll();
  return WithScene(handle, Need::kReady, [&](HapticScene& scene) {
    const std::optional<std::uint32_t> object = ObjectOf(scene, info->node, kChangesShape);
    if (!object) return XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1;
    const bool ask = !std::exchange(scene.surfaces_asked, true);
    const auto reader = link_.WithConnection([ask](client::Connection& connection) {
      if (ask) connection.RequestSurfaces(true);
      return connection.surfaces();
    });
    const bool of_this = reader && reader->scene_generation() == scene.state.generation;
    if (!of_this) return XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1;
    client::SurfaceCopy& copy = scene.surfaces[*object];
    if (!ReadSurface(*reader, *object, copy)) return XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1;
    const XrResult result = Put(copy, scene.state.scale, *mesh);
    if (XR_SUCCEEDED(result)) mesh->time = clock_.ToXr(copy.frame.t_ns);
    return result;
  });
}

}  // namespace omni::layer
