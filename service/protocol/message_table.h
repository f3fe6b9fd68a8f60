// The table of every message on the control socket, one row each. It defines their numbers, names, the variants that a
// receiver gets (messages.h), who may send which, and how it is sent. To add a message, add its row here, its
// structure, the function that checks it, and its handler: the compiler names each missing place.
//
//   name         the structure on the wire, in protocol; with a k before it its number, in MessageType
//   number       never changes, never used again
//   received     the structure that a receiver is handed: the same, or one that also has what follows it
//   descriptors  at most so many come along
#pragma once

#include <cstdint>

namespace omni::protocol {

// Who may send a client's message.
enum Roles : std::uint32_t { kApplications = 1u << 0, kMonitors = 1u << 1, kTools = 1u << 2, kAllRoles = 7 };

// kAnswered: handled once per round, so that a client that floods does not starve the others.
enum class Pace : std::uint8_t { kStream, kAnswered };

// What becomes of a message if the client's socket is full: kOnce: it is lost, and counted. kRepeated: its sender tries
// again.
enum class Delivery : std::uint8_t { kOnce, kRepeated };

}  // namespace omni::protocol

// Client to server, for the server itself.       roles, pace, descriptors
#define OMNI_LINK_MESSAGES(ROW)                     \
  ROW(Hello, 1, Hello, kAllRoles, Pace::kStream, 0) \
  ROW(StatusRequest, 7, StatusRequest, kAllRoles, Pace::kAnswered, 0)

// Client to server, for the service: each is an alternative of protocol::Request.       roles, pace, descriptors
#define OMNI_REQUESTS(ROW)                                                       \
  ROW(Session, 4, Session, kApplications, Pace::kStream, 0)                      \
  ROW(Haptic, 5, Haptic, kApplications, Pace::kStream, 0)                        \
  ROW(HapticStop, 6, HapticStop, kApplications, Pace::kStream, 0)                \
  ROW(Waveform, 14, ShapedHaptic, kApplications, Pace::kStream, 0)               \
  ROW(EmergencyStop, 15, EmergencyStop, kMonitors | kTools, Pace::kStream, 0)    \
  ROW(SceneCommand, 10, SceneCommand, kAllRoles, Pace::kAnswered, 0)             \
  ROW(SurfaceRequest, 12, SurfaceRequest, kAllRoles, Pace::kStream, 0)           \
  ROW(ForceClaim, 20, ForceClaim, kApplications, Pace::kStream, 0)               \
  ROW(ForceApply, 21, ForceApply, kApplications, Pace::kStream, 0)               \
  ROW(ForceConstraints, 22, ForceConstraints, kApplications, Pace::kStream, 0)   \
  ROW(ForceStop, 23, ForceStop, kApplications, Pace::kStream, 0)                 \
  ROW(HapticSceneLoad, 30, HapticSceneLoad, kApplications, Pace::kStream, 1)     \
  ROW(HapticSceneEnd, 31, HapticSceneEnd, kApplications, Pace::kStream, 0)       \
  ROW(HapticScenePlace, 32, HapticScenePlace, kApplications, Pace::kStream, 0)   \
  ROW(HapticSceneEnable, 33, HapticSceneEnable, kApplications, Pace::kStream, 0) \
  ROW(HapticNodes, 34, HapticNodes, kApplications, Pace::kStream, 0)             \
  ROW(HapticMaterial, 35, HapticMaterial, kApplications, Pace::kStream, 0)       \
  ROW(BasePoseRequest, 40, BasePoseRequest, kApplications, Pace::kStream, 0)     \
  ROW(SpaceChange, 42, SpaceChange, kApplications, Pace::kStream, 0)             \
  ROW(BasePoseCommand, 43, BasePoseCommand, kTools, Pace::kAnswered, 0)          \
  ROW(BaseMotion, 45, BaseMotion, kTools, Pace::kStream, 0)

// Server to client.                                    delivery, descriptors
#define OMNI_SERVER_MESSAGES(ROW)                                    \
  ROW(Welcome, 2, Welcome, Delivery::kOnce, 2)                       \
  ROW(Reject, 3, Reject, Delivery::kOnce, 0)                         \
  ROW(StatusReply, 8, StatusReply, Delivery::kOnce, 0)               \
  ROW(Notice, 9, Notice, Delivery::kOnce, 0)                         \
  ROW(SceneReply, 11, SceneAnswer, Delivery::kOnce, 1)               \
  ROW(Surfaces, 13, Surfaces, Delivery::kRepeated, 1)                \
  ROW(ForceOwner, 24, ForceOwner, Delivery::kRepeated, 0)            \
  ROW(ForceProperties, 25, ForceProperties, Delivery::kRepeated, 0)  \
  ROW(HapticSceneState, 36, HapticSceneNews, Delivery::kRepeated, 0) \
  ROW(HapticSceneTable, 37, HapticSceneRows, Delivery::kRepeated, 0) \
  ROW(BasePose, 41, BasePose, Delivery::kRepeated, 0)                \
  ROW(BasePoseReply, 44, BasePoseReply, Delivery::kOnce, 0)          \
  ROW(AppSettings, 50, AppSettings, Delivery::kOnce, 0)
