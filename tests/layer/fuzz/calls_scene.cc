// The fuzzed calls of XR_OMNIX1_haptic_scene.
#include <array>
#include <cmath>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/fuzz/sequence.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace {

constexpr std::uint32_t kRoom = 8;
// What any function may return for a scene that does not exist, is loading, or has failed.
#define OMNI_SCENE_RESULTS                                                                      \
  XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1, \
      XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1

bool AllFinite(const XrVector3f& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

XrHapticNodeIdOMNIX1 Sequence::AnyNode() {
  if (nodes_.empty() || random_.Percent(10))
    return random_.Percent(50) ? XR_NULL_HAPTIC_NODE_ID_OMNIX1 : random_.Bits();
  return random_.Of(nodes_);
}

void Sequence::MakeScene() {
  if (!own_.CreateHapticSceneOMNIX1) return;
  static constexpr std::array<std::uint8_t, 16> kShortestDocument{'{', '"', 'a', '"', ':', '1', '}'};
  static constexpr std::uint32_t kSizes[] = {0, XR_MAX_HAPTIC_SCENE_BYTES_OMNIX1 + 1, 0xFFFFFFFF};
  const std::uint32_t size = random_.Percent(85) ? 1 + random_.Below(16) : kSizes[random_.Below(3)];
  const XrHapticSceneCreateInfoOMNIX1 info{Type(XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1), Chain(), random_.Below(5),
                                           size, OrNull(kShortestDocument.data())};
  XrHapticSceneOMNIX1 scene = XR_NULL_HANDLE;
  const XrSession session = Pick(sessions_);
  const XrResult result = own_.CreateHapticSceneOMNIX1(session, OrNull(&info), OrNull(&scene));
  Say("create scene", result);
  Expect("create scene", result, {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_LIMIT_REACHED});
  if (XR_SUCCEEDED(result)) Keep(scenes_, scene, session);
}

void Sequence::DropScene() {
  if (!own_.DestroyHapticSceneOMNIX1 || random_.Percent(80)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  const XrResult result = own_.DestroyHapticSceneOMNIX1(scene);
  Say("destroy scene", result);
  Expect("destroy scene", result, {XR_ERROR_HANDLE_INVALID});
  if (XR_FAILED(result)) return;
  std::erase(scenes_.live, scene);
  scenes_.dead.push_back(scene);
}

void Sequence::SceneState() {
  if (!own_.GetHapticSceneStateOMNIX1 || Lacks(scenes_)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  XrHapticSceneStateOMNIX1 state{Type(XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1)};
  const XrResult result = own_.GetHapticSceneStateOMNIX1(scene, OrNull(&state));
  Say("scene state", result);
  Expect("scene state", result, {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID});
  if (XR_SUCCEEDED(result) && state.status != XR_HAPTIC_SCENE_STATUS_READY_OMNIX1 &&
      (state.isFelt || state.nodeCount != 0 || state.materialCount != 0 || state.triangleCount != 0))
    Violation("a scene that is not ready has contents");
  char text[64];
  std::uint32_t count = 0;
  const XrResult said =
      own_.GetHapticSceneDiagnosticsOMNIX1(scene, random_.Below(65), OrNull(&count), OrNull(&text[0]));
  Say("scene diagnostics", said);
  Expect("scene diagnostics", said, {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_SIZE_INSUFFICIENT});
}

void Sequence::SceneNodes() {
  if (!own_.EnumerateHapticSceneNodesOMNIX1 || Lacks(scenes_)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  std::array<XrHapticSceneNodeOMNIX1, kRoom> nodes{};
  for (XrHapticSceneNodeOMNIX1& node : nodes) node.type = Type(XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1);
  std::uint32_t count = 0;
  const std::uint32_t capacity = random_.Percent(70) ? kRoom : random_.Below(kRoom);
  const XrResult result = own_.EnumerateHapticSceneNodesOMNIX1(scene, capacity, OrNull(&count), OrNull(nodes.data()));
  Say("scene nodes", result);
  Expect("scene nodes", result, {OMNI_SCENE_RESULTS, XR_ERROR_SIZE_INSUFFICIENT});
  if (XR_FAILED(result) || capacity == 0) return;
  for (std::uint32_t i = 0; i < count && i < capacity; ++i) {
    nodes_.push_back(nodes[i].node);
    CheckPlace(XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT, nodes[i].restPose);
  }
  if (nodes_.size() > 40) nodes_.erase(nodes_.begin(), nodes_.begin() + 20);
}

void Sequence::PlaceScene() {
  if (!own_.SetHapticScenePlacementOMNIX1 || Lacks(scenes_)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  static constexpr float kScales[] = {1, 1, 1, 1, 2, 0.5f, 0, -1, 1e30f};
  const XrHapticScenePlacementOMNIX1 placement{Type(XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1), Chain(), SpaceFor(scene),
                                               AnyPose(),
                                               random_.Percent(95) ? kScales[random_.Below(9)] : AnyNumber()};
  const XrResult result = own_.SetHapticScenePlacementOMNIX1(scene, OrNull(&placement));
  Say("place scene", result);
  Expect("place scene", result, {OMNI_SCENE_RESULTS, XR_ERROR_POSE_INVALID});
  const XrResult enabled = own_.SetHapticSceneEnabledOMNIX1(scene, random_.Below(2));
  Say("enable scene", enabled);
  Expect("enable scene", enabled, {XR_ERROR_HANDLE_INVALID, XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1});
}

void Sequence::MoveNodes() {
  if (!own_.UpdateHapticNodesOMNIX1 || Lacks(scenes_)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  std::array<XrHapticNodePoseOMNIX1, kRoom> poses{};
  for (XrHapticNodePoseOMNIX1& pose : poses) {
    pose = {AnyNode(), random_.Below(2), AnyPose(), {0, 0, 0}, {0, 0, 0}};
    if (random_.Percent(10)) pose.linearVelocity.y = AnyNumber();
    if (random_.Percent(10)) pose.angularVelocity.x = AnyNumber();
    if (random_.Percent(2)) pose.flags = random_.Bits();
  }
  const XrHapticNodesUpdateInfoOMNIX1 info{Type(XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1),
                                           Chain(),
                                           random_.Percent(50) ? XrSpace{XR_NULL_HANDLE} : SpaceFor(scene),
                                           AnyTime(),
                                           random_.Percent(70) ? 1 : random_.Below(kRoom + 1),
                                           OrNull(poses.data())};
  const XrResult result = own_.UpdateHapticNodesOMNIX1(scene, OrNull(&info));
  Say("move nodes", result);
  Expect("move nodes", result,
         {OMNI_SCENE_RESULTS, XR_ERROR_TIME_INVALID, XR_ERROR_POSE_INVALID, XR_ERROR_LIMIT_REACHED,
          XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1});
}

void Sequence::SceneMaterial() {
  if (!own_.GetHapticMaterialOMNIX1 || Lacks(scenes_)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  XrHapticMaterialOMNIX1 material{Type(XR_TYPE_HAPTIC_MATERIAL_OMNIX1)};
  material.stiffness = AnyNumber();
  if (random_.Percent(20)) material.vibrationFrequency = AnyNumber();
  const std::uint32_t index = random_.Percent(95) ? random_.Below(5) : 0xFFFFFFFF;
  const bool sets = random_.Percent(50);
  const XrResult result = sets ? own_.SetHapticMaterialOMNIX1(scene, index, OrNull(&material))
                               : own_.GetHapticMaterialOMNIX1(scene, index, OrNull(&material));
  Say(sets ? "set material" : "get material", result);
  Expect("material", result, {OMNI_SCENE_RESULTS, XR_ERROR_INDEX_OUT_OF_RANGE, XR_ERROR_LIMIT_REACHED});
  if (XR_SUCCEEDED(result) && !sets && !(material.stiffness >= 0 && material.stiffness <= 2000))
    Violation("a stiffness beyond its range");
}

void Sequence::Contacts() {
  if (!own_.EnumerateHapticContactsOMNIX1 || Lacks(scenes_)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  const XrHapticContactsGetInfoOMNIX1 info{Type(XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1), Chain(), SpaceFor(scene),
                                           AnyTime()};
  std::array<XrHapticContactOMNIX1, 4> contacts{};
  for (XrHapticContactOMNIX1& contact : contacts) contact.type = Type(XR_TYPE_HAPTIC_CONTACT_OMNIX1);
  std::uint32_t count = 0;
  const std::uint32_t capacity = random_.Below(5);
  const XrResult result =
      own_.EnumerateHapticContactsOMNIX1(scene, OrNull(&info), capacity, OrNull(&count), OrNull(contacts.data()));
  Say("contacts", result);
  Expect("contacts", result, {OMNI_SCENE_RESULTS, XR_ERROR_TIME_INVALID, XR_ERROR_SIZE_INSUFFICIENT});
  if (XR_FAILED(result)) return;
  if (count > contacts.size()) Violation("more contacts than there can be");
  for (std::uint32_t i = 0; i < count && i < capacity; ++i)
    if (!AllFinite(contacts[i].point) || !AllFinite(contacts[i].normal) || !AllFinite(contacts[i].force))
      Violation("a contact with an invalid point");
}

void Sequence::SceneMesh() {
  if (!own_.GetHapticNodeMeshOMNIX1 || Lacks(scenes_)) return;
  const XrHapticSceneOMNIX1 scene = Pick(scenes_);
  const XrHapticNodeMeshGetInfoOMNIX1 info{Type(XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1), Chain(), AnyNode()};
  std::array<XrVector3f, kRoom> vertices;
  std::array<std::uint32_t, kRoom> indices;
  XrHapticNodeMeshOMNIX1 mesh{Type(XR_TYPE_HAPTIC_NODE_MESH_OMNIX1)};
  mesh.vertexCapacityInput = random_.Below(kRoom);
  mesh.vertices = OrNull(vertices.data());
  mesh.indexCapacityInput = random_.Below(kRoom);
  mesh.indices = OrNull(indices.data());
  const XrResult result = own_.GetHapticNodeMeshOMNIX1(scene, OrNull(&info), OrNull(&mesh));
  Say("mesh", result);
  Expect("mesh", result, {OMNI_SCENE_RESULTS, XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1, XR_ERROR_SIZE_INSUFFICIENT});
}

#undef OMNI_SCENE_RESULTS

}  // namespace omni::test
