// Checks everything that arrives on the control socket: bytes in, one typed message or a reason out.
// Code behind this check need not doubt a size, an enum, a string's end or a number again.
#pragma once

#include <cstddef>
#include <cstdint>

#include "service/protocol/messages.h"

namespace omni::protocol {

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
