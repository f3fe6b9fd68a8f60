// Forces and constraints of an application, over the control socket: types 20 to 29. Base frame, SI.
// A client first claims the pen (ForceClaim); omnid notifies every application of its owner (ForceOwner) and of what
// the device can do (ForceProperties), at the start and at each change. Force, constraints and stop count only while
// the client is the focused owner, else they are dropped. docs/protocol/ipc.md, "Force feedback".
#pragma once

#include <array>
#include <variant>

#include "service/protocol/control.h"

namespace omni::protocol {

inline constexpr std::int64_t kLongestForce_ns = 100'000'000;  // duration and ramp of a force
inline constexpr std::uint32_t kMaxForceConstraints = 8;
inline constexpr std::uint32_t kMaxForceReach = 16;
// Limits of messages; what a device can make is much less.
inline constexpr double kLargestForce_N = 1e4;
inline constexpr double kLargestStiffness_N_m = 1e6;
inline constexpr double kLargestDamping_Ns_m = 1e5;
inline constexpr double kFarthestConstraint_m = 1e4;     // coordinates and radius
inline constexpr double kFastestConstraint_m_s = 1e3;    // and rad/s
inline constexpr double kUnitDirectionTolerance = 1e-6;  // of |d|^2

struct ForceClaim {
  MessageHeader header{.type = MessageType::kForceClaim, .size = sizeof(ForceClaim)};
  std::uint32_t wanted = 0;  // 1: this client has a force feedback handle, 0: no longer
  std::uint32_t reserved = 0;
};

// Replaces the force before. A late message is shortened by its delay.
struct ForceApply {
  MessageHeader header{.type = MessageType::kForceApply, .size = sizeof(ForceApply)};
  std::int64_t t_ns = 0;         // CLOCK_MONOTONIC of the call
  std::int64_t duration_ns = 1;  // 1..kLongestForce_ns, from t_ns
  std::int64_t ramp_ns = 0;      // 0..kLongestForce_ns
  std::array<double, 3> force_base_N{};
};

enum class ForceShape : std::uint32_t { kPoint = 1, kLine = 2, kPlane = 3, kSphere = 4, kViscous = 5 };
struct ForceShapeRow {
  ForceShape shape;
  bool needs_radius = false;  // > 0
};
// In the order of their values, from 1 on.
inline constexpr std::array kForceShapes{
    ForceShapeRow{ForceShape::kPoint},   ForceShapeRow{ForceShape::kLine},
    ForceShapeRow{ForceShape::kPlane},   ForceShapeRow{.shape = ForceShape::kSphere, .needs_radius = true},
    ForceShapeRow{ForceShape::kViscous},
};
enum class ForceSide : std::uint32_t { kOn = 0, kOutside = 1, kInside = 2 };

struct ForceConstraint {
  ForceShape shape = ForceShape::kPoint;
  ForceSide side = ForceSide::kOn;  // of a plane (outside: where its normal points to) or a sphere
  double stiffness_N_m = 0;
  double damping_Ns_m = 0;
  double max_force_N = 0;
  double radius_m = 0;  // of a sphere; line: free within this distance
  std::array<double, 3> point_base_m{};
  std::array<double, 3> direction_base{0, 0, 1};  // unit: along the line, the plane's normal
  // Of the frame in which the shape stands still: of the point, and its rotation.
  std::array<double, 3> velocity_base_m_s{};
  std::array<double, 3> angular_velocity_base_rad_s{};
};

// Replaces all constraints.
struct ForceConstraints {
  MessageHeader header{.type = MessageType::kForceConstraints, .size = sizeof(ForceConstraints)};
  std::int64_t t_ns = 0;  // CLOCK_MONOTONIC at which they stand there
  std::uint32_t count = 0;
  std::uint32_t reserved = 0;
  std::array<ForceConstraint, kMaxForceConstraints> constraints{};
};

// Force and constraints end.
struct ForceStop {
  MessageHeader header{.type = MessageType::kForceStop, .size = sizeof(ForceStop)};
};

enum class ForceStanding : std::uint32_t {
  kFree = 0,   // no client that may push has claimed it
  kYours = 1,  // this client has, and may push
  kTaken = 2   // another application has, and may push
};

struct ForceOwner {
  MessageHeader header{.type = MessageType::kForceOwner, .size = sizeof(ForceOwner)};
  ForceStanding standing = ForceStanding::kFree;
  std::uint32_t reserved = 0;
};

// The largest force in every direction, device point at this distance from the centre of the base.
struct ForceReach {
  double distance_m = 0;
  double force_N = 0;
};

struct ForceProperties {
  MessageHeader header{.type = MessageType::kForceProperties, .size = sizeof(ForceProperties)};
  std::uint32_t available = 0;  // 0: no device; everything else is zero
  std::uint32_t reach_count = 0;
  double max_force_N = 0;
  double continuous_force_N = 0;
  double max_stiffness_N_m = 0;
  double max_damping_Ns_m = 0;
  double update_rate_Hz = 0;
  double inner_radius_m = 0;  // of the device point
  double outer_radius_m = 0;
  std::array<ForceReach, kMaxForceReach> reach{};  // by rising distance
};

// What a client may request.
using ForceRequest = std::variant<ForceClaim, ForceApply, ForceConstraints, ForceStop>;

// What is wrong with the fields of a message; null: nothing.
const char* Problem(const ForceClaim& claim) noexcept;
const char* Problem(const ForceApply& apply) noexcept;
const char* Problem(const ForceConstraints& constraints) noexcept;
const char* Problem(const ForceStop& stop) noexcept;
const char* Problem(const ForceOwner& owner) noexcept;
const char* Problem(const ForceProperties& properties) noexcept;

static_assert(sizeof(ForceApply) == 64 && sizeof(ForceConstraint) == 136 && sizeof(ForceConstraints) == 1120);
static_assert(sizeof(ForceProperties) == 336);

}  // namespace omni::protocol
