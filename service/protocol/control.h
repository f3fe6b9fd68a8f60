// Control messages between omnid and its clients, over a Unix seqpacket socket (one message = one packet).
// Plain data, std only. Every message starts with MessageHeader; `size` is the whole packet.
// A receiver refuses a wrong magic, a size that does not fit the type, and an unterminated string.
// Version rule: equal `kProtocolVersion` or the server answers Reject (its version, a text) and closes.
// MessageHeader and Reject keep their layout in every version. message_table.h lists all messages; messages.h is the
// gate for received bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "service/protocol/message_table.h"

namespace omni::protocol {

inline constexpr std::uint32_t kMessageMagic = 0x494E4D4F;  // "OMNI"
// 2: scene commands, surfaces; 3: see docs/protocol/ipc.md; 4: emergency stop, telemetry; 5: a base that moves.
// Incremented when a message changes its size or meaning.
inline constexpr std::uint16_t kProtocolVersion = 5;
inline constexpr std::size_t kMaterialBytes = 88;  // of base::MaterialParameters in this version
inline constexpr std::size_t kMaxMessageBytes = 65536;
inline constexpr std::size_t kMaxSocketPathBytes = 107;

// Numbers of the table.
enum class MessageType : std::uint16_t {
#define OMNI_NUMBER(name, number, ...) k##name = number,
  OMNI_LINK_MESSAGES(OMNI_NUMBER) OMNI_REQUESTS(OMNI_NUMBER) OMNI_SERVER_MESSAGES(OMNI_NUMBER)
#undef OMNI_NUMBER
};

struct MessageHeader {
  std::uint32_t magic = kMessageMagic;
  std::uint16_t version = kProtocolVersion;
  MessageType type = MessageType::kHello;
  std::uint32_t size = 0;
  std::uint32_t reserved = 0;
};

// What kind of client: only kApplication can own the force and has spaces, only kTool may change alignments.
enum class ClientRole : std::uint32_t { kApplication = 1, kMonitor = 2, kTool = 3 };

struct Hello {
  MessageHeader header{.type = MessageType::kHello, .size = sizeof(Hello)};
  ClientRole role = ClientRole::kApplication;
  std::uint32_t api_version_major = 1;
  std::uint32_t api_version_minor = 0;
  std::uint32_t reserved = 0;
  char application[128] = {};  // XrApplicationInfo::applicationName, UTF-8, terminated
  char engine[128] = {};
};

struct Welcome {
  MessageHeader header{.type = MessageType::kWelcome, .size = sizeof(Welcome)};
  std::uint64_t client_id = 0;         // unique in this service instance, never 0
  std::uint64_t service_instance = 0;  // random, changes when omnid restarts
  std::uint32_t state_bytes = 0;       // size of the state memory
  std::uint32_t life_bytes = 0;        // size of the life page
};

struct Reject {
  MessageHeader header{.type = MessageType::kReject, .size = sizeof(Reject)};
  std::uint32_t server_version = kProtocolVersion;
  std::uint32_t reserved = 0;
  char reason[248] = {};
};

// Only kFocused makes a client an owner; leaving it, or the end of the socket, takes the force away.
enum class SessionState : std::uint32_t { kNone = 0, kBegun = 1, kFocused = 2 };

struct Session {
  MessageHeader header{.type = MessageType::kSession, .size = sizeof(Session)};
  SessionState state = SessionState::kNone;
  std::uint32_t reserved = 0;
};

struct Haptic {
  MessageHeader header{.type = MessageType::kHaptic, .size = sizeof(Haptic)};
  std::int64_t duration_ns = 0;  // -1: shortest pulse the device can make
  float amplitude = 0;           // 0..1
  float frequency_Hz = 0;        // 0: the device's best
};

struct HapticStop {
  MessageHeader header{.type = MessageType::kHapticStop, .size = sizeof(HapticStop)};
};

struct StatusRequest {
  MessageHeader header{.type = MessageType::kStatusRequest, .size = sizeof(StatusRequest)};
};

// on: no force, no vibration, coils at zero, whatever applications request, until someone sends it with on = 0, or
// omnid ends. Applications can neither send nor release it.
struct EmergencyStop {
  MessageHeader header{.type = MessageType::kEmergencyStop, .size = sizeof(EmergencyStop)};
  std::uint32_t on = 1;  // 0 released, 1 stopped
  std::uint32_t reserved = 0;
};

// The newest request counts. Answered with Surfaces at once and again whenever the memory is another one.
struct SurfaceRequest {
  MessageHeader header{.type = MessageType::kSurfaceRequest, .size = sizeof(SurfaceRequest)};
  std::uint32_t wanted = 0;  // 0 no, 1 yes
  std::uint32_t reserved = 0;
};

// Layout: surface_memory.h. total_bytes 0: no descriptor, nothing in the present scene changes its shape or place.
struct Surfaces {
  MessageHeader header{.type = MessageType::kSurfaces, .size = sizeof(Surfaces)};
  std::uint64_t total_bytes = 0;
  std::uint64_t memory_generation = 0;  // the memory's own; 0 with total_bytes 0
};

struct Notice {
  MessageHeader header{.type = MessageType::kNotice, .size = sizeof(Notice)};
  std::uint32_t level = 0;  // 0 info, 1 warning, 2 error
  std::uint32_t reserved = 0;
  char text[1000] = {};
};

enum class SceneAction : std::uint32_t { kEdits = 1, kUndo = 2, kRedo = 3, kSave = 4, kRelease = 5 };

// A request to do something with a sculpted scene; answered by one SceneReply. Any client may send it.
struct SceneCommand {
  MessageHeader header{.type = MessageType::kSceneCommand, .size = sizeof(SceneCommand)};
  SceneAction action = SceneAction::kEdits;
  std::uint32_t number = 0;     // comes back in the reply
  std::uint64_t client_id = 0;  // whose scene; 0: the owner's if it is sculpted, else the only one that is
  char object[128] = {};        // UTF-8; kUndo, kRedo: name or index; empty: the one that was edited last
};

// Followed by a text of header.size - sizeof(SceneReply) bytes: kEdits JSON, else a line for people.
struct SceneReply {
  MessageHeader header{.type = MessageType::kSceneReply, .size = sizeof(SceneReply)};
  std::uint32_t number = 0;      // of the command
  std::uint32_t done = 0;        // 1: done, 0: refused, the text says why
  std::uint64_t file_bytes = 0;  // > 0: a descriptor came along: memory of this size, a whole .glb file
};

static_assert(std::is_trivially_copyable_v<SceneCommand> && std::is_trivially_copyable_v<SceneReply>);
static_assert(sizeof(SceneCommand) == 160 && sizeof(SceneReply) == 32);
static_assert(std::is_trivially_copyable_v<Hello> && std::is_trivially_copyable_v<Notice>);
static_assert(sizeof(MessageHeader) == 16 && sizeof(Hello) == 288 && sizeof(Welcome) == 40 && sizeof(Reject) == 272);

// Settings from the service for an application's OpenXR layer: sent after Welcome, and again when they change.
enum class HandSetting : std::uint32_t { kUnset = 0, kLeft = 1, kRight = 2 };

inline constexpr float kLongestRest_s = 86400;

struct AppSettings {
  MessageHeader header{.type = MessageType::kAppSettings, .size = sizeof(AppSettings)};
  HandSetting hand = HandSetting::kUnset;  // the hand that holds the pen
  float rest_after_s = 0;                  // put down after lying still for so long; 0: the layer's default, < 0: never
  char profile[128] = {};                  // interaction profile path to prefer, terminated; empty: the layer's order
};
static_assert(std::is_trivially_copyable_v<AppSettings> && sizeof(AppSettings) == 152);

}  // namespace omni::protocol
