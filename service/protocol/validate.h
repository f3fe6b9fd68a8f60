// The gate for everything that arrives on the control socket: bytes in, one typed message or a reason out.
// Nothing behind this gate has to doubt a size, an enum, a string's end or a number again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "service/protocol/app_settings.h"
#include "service/protocol/control.h"
#include "service/protocol/force_feedback.h"
#include "service/protocol/haptic_scene.h"
#include "service/protocol/placement.h"
#include "service/protocol/waveform.h"

namespace omni::protocol {

inline constexpr std::int64_t kShortestPulse_ns = -1;  // XR_MIN_HAPTIC_DURATION
inline constexpr float kHighestFrequency_Hz = 1e5f;

struct Invalid {
  bool other_version = false;  // a sound header of another version: the sender is not hostile, just not ours
  std::uint16_t version = 0;
  char reason[200] = {};
};

// The text behind a kStatusReply header. A view into the validated bytes.
struct StatusReply {
  std::string_view json;
};

// A SceneReply with the text behind it, a view into the validated bytes.
struct SceneAnswer {
  SceneReply reply;
  std::string_view text;
};

// A HapticSceneState with the text behind it, a view into the validated bytes.
struct HapticSceneNews {
  HapticSceneState state;
  std::string_view text;
};

// A HapticSceneTable; rows are copied out of the validated bytes one by one (they need not be aligned there).
struct HapticSceneRows {
  HapticSceneTable table;
  const std::byte* rows = nullptr;
  HapticNodeRow Node(std::uint32_t i) const noexcept;                 // i < table.node_count
  base::MaterialParameters Material(std::uint32_t i) const noexcept;  // i < table.material_count
};

using Message =
    std::variant<Invalid, Hello, Welcome, Reject, Session, Haptic, HapticStop, StatusRequest, StatusReply, Notice,
                 SceneCommand, SceneAnswer, SurfaceRequest, Surfaces, ShapedHaptic, HapticSceneLoad, HapticSceneEnd,
                 HapticScenePlace, HapticSceneEnable, HapticNodes, HapticMaterial, HapticSceneNews, HapticSceneRows,
                 AppSettings, ForceClaim, ForceApply, ForceConstraints, ForceStop, ForceOwner, ForceProperties,
                 PlacementRequest, Placement, SpaceChange, PlacementCommand, PlacementReply>;

// MessageHeader and Reject keep their layout in every version, so that either side can say "other version".
Message Validate(const void* bytes, std::size_t size) noexcept;

// Name of a type for reasons and logs; "unknown" if there is none.
const char* TypeName(MessageType type) noexcept;

}  // namespace omni::protocol
