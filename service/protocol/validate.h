// The gate for everything that arrives on the control socket: bytes in, one typed message or a reason out.
// Nothing behind this gate has to doubt a size, an enum, a string's end or a number again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "service/protocol/control.h"
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

using Message = std::variant<Invalid, Hello, Welcome, Reject, Session, Haptic, HapticStop, StatusRequest, StatusReply,
                             Notice, SceneCommand, SceneAnswer, SurfaceRequest, Surfaces, ShapedHaptic>;

// MessageHeader and Reject keep their layout in every version, so that either side can say "other version".
Message Validate(const void* bytes, std::size_t size) noexcept;

// Name of a type for reasons and logs; "unknown" if there is none.
const char* TypeName(MessageType type) noexcept;

}  // namespace omni::protocol
