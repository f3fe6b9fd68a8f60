// Messages 40-45: where the base stands in a reference space of an application's runtime. docs/protocol/ipc.md
// X_LB: pose of the base B (z up) in the reference space L (OpenXR: metres, y up). Quaternions w, x, y, z.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "service/protocol/control.h"

namespace omni::protocol {

inline constexpr std::uint32_t kMaxSpaceTypes = 8;
inline constexpr double kFarthestBase_m = 100;  // from a reference space's origin
// Limits of recentring, relative to the measured pose: within a room, and almost no tilt, since all these spaces have
// gravity along -y.
inline constexpr double kFarthestRecentring_m = 10;
inline constexpr double kMostRecentringTilt_rad = 0.175;
// Reports of one and the same change of a reference space, by several applications, differ by less; a person does not
// recentre twice within it.
inline constexpr std::int64_t kSameChange_ns = 150'000'000;
// Of a base that moves: far above what is plausible (daemon/clients/followed_base.h).
inline constexpr double kFastestWireBase_m_s = 100;
inline constexpr double kFastestWireTurn_rad_s = 100;

// XrReferenceSpaceType, in order of preference: those that recentring moves least come first.
inline constexpr std::int32_t kSpaceStage = 3;
inline constexpr std::int32_t kSpaceLocalFloor = 1000426000;
inline constexpr std::int32_t kSpaceLocal = 2;
inline constexpr std::array<std::int32_t, 3> kPreferredSpaces{kSpaceStage, kSpaceLocalFloor, kSpaceLocal};

// A headset as its runtime names it: the key of a base pose, with the space's type.
struct HeadsetNames {
  char runtime[128] = {};  // XrInstanceProperties::runtimeName, UTF-8, terminated
  char system[256] = {};   // XrSystemProperties::systemName
};

struct WirePose {
  std::array<double, 3> position_m{};
  std::array<double, 4> orientation_wxyz{1, 0, 0, 0};
};

// application -> omnid, once per session: requests the base pose in one of these spaces. The answer is the first known
// one, in the order given; every later change of it is sent as well.
struct BasePoseRequest {
  MessageHeader header{.type = MessageType::kBasePoseRequest, .size = sizeof(BasePoseRequest)};
  std::uint32_t space_count = 0;
  std::array<std::int32_t, kMaxSpaceTypes> spaces{};
  std::uint32_t reserved = 0;
  HeadsetNames headset;
};

// What a pen does while its base's place is not known.
enum class Uncalibrated : std::uint32_t {
  kFrontOfUser = 0,  // the layer puts the base in front of the user, and clears TRACKED
  kCalibrated = 1,   // no pose
  kOff = 2           // no pose, though a base pose may be known
};

// omnid -> application.
struct BasePose {
  MessageHeader header{.type = MessageType::kBasePose, .size = sizeof(BasePose)};
  std::uint32_t known = 0;  // 1: measured; 0: only `uncalibrated` is meaningful
  Uncalibrated uncalibrated = Uncalibrated::kFrontOfUser;
  std::int32_t space = kSpaceLocal;
  std::uint32_t doubtful = 0;   // 1: the space has moved since, to an unknown or implausible pose
  WirePose base_space;          // X_LB
  double expected_error_m = 0;  // 1 sigma where the pen is used; 0: not stated
  double rotation_sigma_rad = 0;
  std::int64_t measured_unix_s = 0;
  std::int64_t changes_until_ns = 0;  // CLOCK_MONOTONIC: changes of the space up to then are in X_LB
  std::uint64_t revision = 0;         // counts changes of this record since omnid's start
  std::uint32_t follows = 0;          // 1: the base moves; where it is stands in the state memory (BaseSample)
  std::uint32_t reserved = 0;
};

// application -> omnid: XrEventDataReferenceSpaceChangePending, for a space that it named in its BasePoseRequest.
// Ignored before its session has begun for the first time.
struct SpaceChange {
  MessageHeader header{.type = MessageType::kSpaceChange, .size = sizeof(SpaceChange)};
  std::int32_t space = kSpaceLocal;
  std::uint32_t pose_valid = 0;    // 0: the runtime does not know where the new origin is
  std::int64_t changes_at_ns = 0;  // CLOCK_MONOTONIC
  WirePose new_in_previous;        // poseInPreviousSpace
};

enum class BasePoseAction : std::uint32_t {
  kStore = 1,    // X_LB and what is known of it
  kForget = 2,   // of this headset and space; empty runtime: all
  kPolicy = 3,   // `uncalibrated` for all headsets
  kRestore = 4,  // of this headset and space: as it was measured, before any recentring
  // of this headset and space: the base's origin was found at base_space.position_m, its orientation was not measured
  kCheck = 5
};

// omni align -> omnid; answered by one BasePoseReply. Tools only.
struct BasePoseCommand {
  MessageHeader header{.type = MessageType::kBasePoseCommand, .size = sizeof(BasePoseCommand)};
  BasePoseAction action = BasePoseAction::kStore;
  std::uint32_t number = 0;  // comes back in the reply
  HeadsetNames headset;
  std::int32_t space = kSpaceLocal;
  Uncalibrated uncalibrated = Uncalibrated::kFrontOfUser;
  WirePose base_space;
  double rms_m = 0;
  double expected_error_m = 0;
  double rotation_sigma_rad = 0;
  std::uint32_t samples = 0;
  std::uint32_t correct = 0;  // 1: kCheck also moves the base pose there
  char method[32] = {};
};

struct BasePoseReply {
  MessageHeader header{.type = MessageType::kBasePoseReply, .size = sizeof(BasePoseReply)};
  std::uint32_t number = 0;
  std::uint32_t done = 0;  // 0: refused, the text says why
  char text[1000] = {};
};

enum class BaseState : std::uint32_t {
  kLost = 0,   // the source does not see the base: pose and velocities are meaningless
  kSeen = 1,   // it stands at base_space at t_ns, and moves with these velocities
  kStands = 2  // it moves no more: from now on the stored alignment holds
};

// tool -> omnid: where a base is that something carries, as often as it is known. Only one client at a time.
struct BaseMotion {
  MessageHeader header{.type = MessageType::kBaseMotion, .size = sizeof(BaseMotion)};
  BaseState state = BaseState::kSeen;
  std::int32_t space = kSpaceLocal;
  std::int64_t t_ns = 0;  // CLOCK_MONOTONIC when it is there
  HeadsetNames headset;
  WirePose base_space;                             // X_LB
  std::array<double, 3> linear_velocity_m_s{};     // of B's origin, in L
  std::array<double, 3> angular_velocity_rad_s{};  // in L
};

static_assert(std::is_trivially_copyable_v<BaseMotion> && sizeof(BaseMotion) == 520);
static_assert(std::is_trivially_copyable_v<BasePoseCommand> && std::is_trivially_copyable_v<BasePoseRequest>);
static_assert(sizeof(BasePoseRequest) == 440 && sizeof(BasePose) == 136 && sizeof(SpaceChange) == 88);
static_assert(sizeof(BasePoseCommand) == 536 && sizeof(BasePoseReply) == 1024);

// What is wrong with the numbers of a pose; null: nothing. Unit quaternion (|q|^2 within 1e-2 of 1), finite, within
// kFarthestBase_m.
inline const char* PoseProblem(const WirePose& pose) noexcept {
  for (const double x : pose.position_m) {
    if (!(std::abs(x) <= kFarthestBase_m)) return "position_m is not within 100 m";
  }
  double norm2 = 0;
  for (const double x : pose.orientation_wxyz) norm2 += x * x;
  return norm2 >= 0.99 && norm2 <= 1.01 ? nullptr : "orientation_wxyz is not a unit quaternion";
}

}  // namespace omni::protocol
