// Messages as a receiver gets them: one variant per direction, made from message_table.h, the traits of each, and the
// check of received bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "service/protocol/base_pose.h"
#include "service/protocol/control.h"
#include "service/protocol/force_feedback.h"
#include "service/protocol/haptic_scene.h"
#include "service/protocol/waveform.h"

namespace omni::protocol {

// An invalid message, and why.
struct Invalid {
  bool other_version = false;  // a valid header of another version: the sender is not hostile, but incompatible
  std::uint16_t version = 0;
  char reason[200] = {};
};

// The text behind a kStatusReply header. A view into the received bytes, as the next two.
struct StatusReply {
  std::string_view json;
};

struct SceneAnswer {
  SceneReply reply;
  std::string_view text;
};

struct HapticSceneNews {
  HapticSceneState state;
  std::string_view text;
};

// Rows are copied out of the received bytes one by one (they need not be aligned there).
struct HapticSceneRows {
  HapticSceneTable table;
  const std::byte* rows = nullptr;
  HapticNodeRow Node(std::uint32_t i) const noexcept;                 // i < table.node_count
  base::MaterialParameters Material(std::uint32_t i) const noexcept;  // i < table.material_count
};

// Of a message as it is received: kType, kName, kDescriptors; of a client's kRoles and kPace, of the server's
// kDelivery.
template <class M>
struct Traits;

#define OMNI_CLIENT_TRAITS(name, number, received, roles, pace, descriptors) \
  template <>                                                                \
  struct Traits<received> {                                                  \
    static constexpr MessageType kType = MessageType::k##name;               \
    static constexpr const char* kName = #name;                              \
    static constexpr bool kOfClient = true;                                  \
    static constexpr std::uint32_t kRoles = roles;                           \
    static constexpr Pace kPace = pace;                                      \
    static constexpr std::size_t kDescriptors = descriptors;                 \
  };
OMNI_LINK_MESSAGES(OMNI_CLIENT_TRAITS)
OMNI_REQUESTS(OMNI_CLIENT_TRAITS)
#undef OMNI_CLIENT_TRAITS

#define OMNI_SERVER_TRAITS(name, number, received, delivery, descriptors) \
  template <>                                                             \
  struct Traits<received> {                                               \
    static constexpr MessageType kType = MessageType::k##name;            \
    static constexpr const char* kName = #name;                           \
    static constexpr bool kOfClient = false;                              \
    static constexpr Delivery kDelivery = delivery;                       \
    static constexpr std::size_t kDescriptors = descriptors;              \
  };
OMNI_SERVER_MESSAGES(OMNI_SERVER_TRAITS)
#undef OMNI_SERVER_TRAITS

// A bit of Roles.
constexpr std::uint32_t RoleBit(ClientRole role) noexcept { return 1u << (static_cast<std::uint32_t>(role) - 1); }

template <class... M>
struct MessageList;
template <class Unused, class... M>
struct MessageList<Unused, M...> {
  using Variant = std::variant<M...>;
};

#define OMNI_ALTERNATIVE(name, number, received, ...) , received
using ClientMessage = std::variant<Invalid OMNI_LINK_MESSAGES(OMNI_ALTERNATIVE) OMNI_REQUESTS(OMNI_ALTERNATIVE)>;
using ServerMessage = std::variant<Invalid OMNI_SERVER_MESSAGES(OMNI_ALTERNATIVE)>;
using Message = std::variant<Invalid OMNI_LINK_MESSAGES(OMNI_ALTERNATIVE) OMNI_REQUESTS(OMNI_ALTERNATIVE)
                                 OMNI_SERVER_MESSAGES(OMNI_ALTERNATIVE)>;
// The messages that a ServerHandler handles.
using Request = MessageList<void OMNI_REQUESTS(OMNI_ALTERNATIVE)>::Variant;
#undef OMNI_ALTERNATIVE

// Checks everything that arrives on the control socket: bytes in, one typed message or a reason out.
// Code behind this check need not doubt a size, an enum, a string's end or a number again.
inline constexpr std::int64_t kShortestPulse_ns = -1;  // XR_MIN_HAPTIC_DURATION
inline constexpr float kHighestFrequency_Hz = 1e5f;

// MessageHeader and Reject keep their layout in every version, so that either side can report another version. A
// message of the other direction is Invalid; Validate accepts both.
ClientMessage ValidateFromClient(const void* bytes, std::size_t size) noexcept;
ServerMessage ValidateFromServer(const void* bytes, std::size_t size) noexcept;
Message Validate(const void* bytes, std::size_t size) noexcept;

// Table entries of a type; "unknown", 0 and kOnce if there is none.
const char* TypeName(MessageType type) noexcept;
std::uint32_t RolesOf(MessageType type) noexcept;  // 0: only the server sends it
Delivery DeliveryOf(MessageType type) noexcept;

}  // namespace omni::protocol
