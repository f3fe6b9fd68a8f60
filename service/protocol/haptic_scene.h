// Messages about an application's own scene (XR_OMNIX1_haptic_scene), types 30 to 39. Version rule and header:
// control.h. A client has at most one such scene; `number` counts those that it has made, and messages about any other
// number than the present one are ignored: that scene has ended already.
//
// Frames: the scene's own frame is z up, as a scene from apps.d stands at the base: (x, y, z) = (x, -z, y) of the glTF
// document. Lengths in it are metres after the scale. SI; quaternions w, x, y, z, within 2 % of unit.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/material.h"
#include "service/protocol/control.h"

namespace omni::protocol {

inline constexpr std::uint64_t kMaxHapticSceneBytes = 256u << 20;
inline constexpr double kLeastSceneScale = 1e-4, kMostSceneScale = 1e4;
inline constexpr std::uint32_t kMaxHapticNodesMoved = 16;    // different ones, and in one message
inline constexpr std::uint32_t kMaxHapticNodes = 64;         // that a scene has
inline constexpr std::uint32_t kMaxHapticMaterials = 256;    // that can be named
inline constexpr std::uint32_t kMaxHapticMaterialsSet = 16;  // different ones
inline constexpr double kMaxScenePosition_m = 1e3;
inline constexpr double kMaxSceneSpeed = 1e3;  // m/s and rad/s

enum HapticSceneFlag : std::uint32_t {
  kSceneTouchUntagged = 1u << 0,  // a document without haptic tags is touched as a whole
  kSceneAllKinematic = 1u << 1    // every node may be moved
};

// Replaces the last scene. One descriptor comes along: memory of `bytes` bytes with a glTF document, sealed WRITE |
// SHRINK | GROW, so that it cannot change any more.
struct HapticSceneLoad {
  MessageHeader header{.type = MessageType::kHapticSceneLoad, .size = sizeof(HapticSceneLoad)};
  std::uint32_t number = 0;  // not 0
  std::uint32_t flags = 0;   // HapticSceneFlag
  std::uint64_t bytes = 0;   // 1 to kMaxHapticSceneBytes
  double scale = 1;          // of the document
};

struct HapticSceneEnd {
  MessageHeader header{.type = MessageType::kHapticSceneEnd, .size = sizeof(HapticSceneEnd)};
  std::uint32_t number = 0;
  std::uint32_t reserved = 0;
};

// Of a body at one time.
struct ScenePose {
  std::array<double, 4> rotation_wxyz{1, 0, 0, 0};
  std::array<double, 3> position_m{};
  std::array<double, 3> velocity_m_s{};
  std::array<double, 3> angular_velocity_rad_s{};
};

enum ScenePoseFlag : std::uint32_t { kPoseLeaps = 1u << 0 };  // jumps there instead of moving

// Where the scene's frame stands in the base frame. Another scale reloads it.
struct HapticScenePlace {
  MessageHeader header{.type = MessageType::kHapticScenePlace, .size = sizeof(HapticScenePlace)};
  std::uint32_t number = 0;
  std::uint32_t flags = 0;  // ScenePoseFlag
  std::int64_t t_ns = 0;    // CLOCK_MONOTONIC when it is there; may lie ahead
  double scale = 1;
  ScenePose pose;
};

struct HapticSceneEnable {
  MessageHeader header{.type = MessageType::kHapticSceneEnable, .size = sizeof(HapticSceneEnable)};
  std::uint32_t number = 0;
  std::uint32_t enabled = 0;  // 0 or 1
};

// x = R x_rest + position in the scene's frame.
struct HapticNodePose {
  std::uint32_t object = 0;  // as in the table
  std::uint32_t flags = 0;   // ScenePoseFlag
  ScenePose pose;
};

struct HapticNodes {
  MessageHeader header{.type = MessageType::kHapticNodes, .size = sizeof(HapticNodes)};
  std::uint32_t number = 0;
  std::uint32_t count = 0;  // 1 to kMaxHapticNodesMoved; the rest is ignored
  std::int64_t t_ns = 0;    // as above
  std::array<HapticNodePose, kMaxHapticNodesMoved> nodes;
};

struct HapticMaterial {
  MessageHeader header{.type = MessageType::kHapticMaterial, .size = sizeof(HapticMaterial)};
  std::uint32_t number = 0;
  std::uint32_t material = 0;  // below kMaxHapticMaterials
  base::MaterialParameters parameters;
};

enum class HapticSceneStatus : std::uint32_t { kLoading = 0, kReady = 1, kFailed = 2 };

// Server to client, whenever any of it changes. Followed by a text of header.size - sizeof(HapticSceneState) bytes:
// ready: warnings; failed: "<JSON pointer>: what, limit, what to do"; lines.
struct HapticSceneState {
  MessageHeader header{.type = MessageType::kHapticSceneState, .size = sizeof(HapticSceneState)};
  std::uint32_t number = 0;
  HapticSceneStatus status = HapticSceneStatus::kLoading;
  std::uint64_t generation = 0;  // of the scene in the state memory's contacts and in surfaces; 0: it is not active
  double scale = 1;              // of the active scene: the requested one once it is ready
  std::int64_t load_ns = 0;      // from the document's arrival to ready or failed
  std::uint32_t triangle_count = 0;
  std::uint32_t material_count = 0;  // of the scene; the table names the first kMaxHapticMaterials
};

enum HapticNodeFlag : std::uint32_t {
  kNodeKinematic = 1u << 0,
  kNodeSoft = 1u << 1,
  kNodeSculptable = 1u << 2,
  kNodeExtrudable = 1u << 3,
  kNodeDoubleSided = 1u << 4
};
inline constexpr std::uint32_t kAllNodeFlags = 31;

struct HapticNodeRow {
  std::int32_t gltf_node = -1;  // -1: several
  std::uint32_t flags = 0;      // HapticNodeFlag
  std::uint32_t material = 0;
  std::uint32_t triangle_count = 0;
  std::array<double, 4> rest_rotation_wxyz{1, 0, 0, 0};  // of the node in the document's frame (y up), unit
  std::array<double, 3> rest_position_m{};               // document's metres
  char name[48] = {};                                    // UTF-8, terminated
};

// Server to client, before the first state "ready" and again after a scene was reloaded. Row i of the nodes is
// object i. Followed by node_count HapticNodeRow, then material_count base::MaterialParameters.
struct HapticSceneTable {
  MessageHeader header{.type = MessageType::kHapticSceneTable, .size = sizeof(HapticSceneTable)};
  std::uint32_t number = 0;
  std::uint32_t node_count = 0;
  std::uint32_t material_count = 0;  // at most kMaxHapticMaterials
  std::uint32_t reserved = 0;
};

static_assert(std::is_trivially_copyable_v<HapticNodes> && sizeof(HapticNodePose) == 112);
static_assert(sizeof(base::MaterialParameters) == kMaterialBytes,
              "a material has other live numbers: count up kProtocolVersion and set kMaterialBytes (control.h)");
static_assert(sizeof(HapticSceneLoad) == 40 && sizeof(HapticScenePlace) == 144 && sizeof(HapticSceneState) == 56);
static_assert(sizeof(HapticNodeRow) == 120 && sizeof(HapticSceneTable) == 32);
static_assert(sizeof(HapticSceneTable) + kMaxHapticNodes * sizeof(HapticNodeRow) +
                  kMaxHapticMaterials * sizeof(base::MaterialParameters) <=
              kMaxMessageBytes);

// What is wrong with a message about a haptic scene; null: nothing. Used by validate.cc, the gate.
const char* Problem(const HapticSceneLoad& load) noexcept;
const char* Problem(const HapticSceneEnd& end) noexcept;
const char* Problem(const HapticScenePlace& place) noexcept;
const char* Problem(const HapticSceneEnable& enable) noexcept;
const char* Problem(const HapticNodes& nodes) noexcept;
const char* Problem(const HapticMaterial& material) noexcept;
const char* Problem(const HapticSceneState& state) noexcept;
const char* Problem(const HapticSceneTable& table) noexcept;
const char* Problem(const HapticNodeRow& row) noexcept;
const char* Problem(const base::MaterialParameters& parameters) noexcept;

}  // namespace omni::protocol
