#include "service/protocol/messages.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "service/protocol/haptic_scene.h"
#include "service/protocol/sample_range.h"
#include "service/protocol/state_memory.h"
#include "service/protocol/surfaces/surface_memory.h"
#include "service/protocol/text.h"

namespace omni::protocol {
namespace {

[[gnu::format(printf, 1, 2)]] Invalid Because(const char* format, ...) noexcept {
  Invalid invalid;
  std::va_list arguments;
  va_start(arguments, format);
  // The analyzer does not see through va_start here.
  std::vsnprintf(invalid.reason, sizeof(invalid.reason), format, arguments);  // NOLINT(clang-analyzer-valist.*)
  va_end(arguments);
  return invalid;
}

// What is wrong with the fields of a message of the right size; null: nothing.
const char* Problem(const Hello& hello) noexcept {
  if (hello.role < ClientRole::kApplication || hello.role > ClientRole::kTool) return "role is not in 1..3";
  if (!IsTerminated(hello.application)) return "application is not terminated";
  return IsTerminated(hello.engine) ? nullptr : "engine is not terminated";
}

const char* Problem(const Welcome& welcome) noexcept {
  if (welcome.client_id == 0) return "client_id is 0";
  if (welcome.state_bytes != sizeof(StateMemory)) return "state_bytes is not the size of the state memory";
  return welcome.life_bytes == kLifePageBytes ? nullptr : "life_bytes is not 4096";
}

const char* Problem(const Reject& reject) noexcept {
  return IsTerminated(reject.reason) ? nullptr : "reason is not terminated";
}

const char* Problem(const Session& session) noexcept {
  return session.state <= SessionState::kFocused ? nullptr : "state is not 0, 1 or 2";
}

const char* Problem(const Haptic& haptic) noexcept {
  if (!(haptic.duration_ns >= kShortestPulse_ns)) return "duration_ns is below -1";
  if (!(haptic.amplitude >= 0 && haptic.amplitude <= 1)) return "amplitude is not in 0..1";
  const bool frequency_ok = haptic.frequency_Hz >= 0 && haptic.frequency_Hz <= kHighestFrequency_Hz;
  return frequency_ok ? nullptr : "frequency_Hz is not in 0..1e5";
}

const char* Problem(const HapticStop&) noexcept { return nullptr; }
const char* Problem(const StatusRequest&) noexcept { return nullptr; }

const char* Problem(const Notice& notice) noexcept {
  if (notice.level > 2) return "level is above 2";
  return IsTerminated(notice.text) ? nullptr : "text is not terminated";
}

const char* Problem(const EmergencyStop& stop) noexcept { return stop.on <= 1 ? nullptr : "on is neither 0 nor 1"; }

const char* Problem(const SurfaceRequest& request) noexcept {
  return request.wanted <= 1 ? nullptr : "wanted is neither 0 nor 1";
}

const char* Problem(const Surfaces& surfaces) noexcept {
  if (!(surfaces.total_bytes <= kMaxSurfaceBytes)) return "total_bytes is above 2^30";
  const bool both = (surfaces.total_bytes == 0) == (surfaces.memory_generation == 0);
  return both ? nullptr : "total_bytes without memory_generation, or the reverse";
}

const char* Problem(const SceneCommand& command) noexcept {
  if (command.action < SceneAction::kEdits || command.action > SceneAction::kRelease) return "action is not in 1..5";
  return IsTerminated(command.object) ? nullptr : "object is not terminated";
}

const char* Problem(const SceneReply& reply) noexcept {
  if (reply.done > 1) return "done is neither 0 nor 1";
  return reply.done == 1 || reply.file_bytes == 0 ? nullptr : "a refusal with a file";
}

const char* Problem(const AppSettings& settings) noexcept {
  if (settings.hand > HandSetting::kRight) return "hand is not 0, 1 or 2";
  if (!(settings.rest_after_s >= -1 && settings.rest_after_s <= kLongestRest_s))
    return "rest_after_s is not in -1..86400";
  return IsTerminated(settings.profile) ? nullptr : "profile is not terminated";
}

const char* Problem(const HeadsetNames& headset) noexcept {
  if (!IsTerminated(headset.runtime)) return "runtime is not terminated";
  return IsTerminated(headset.system) ? nullptr : "system is not terminated";
}

const char* Problem(const BasePoseRequest& request) noexcept {
  if (!(request.space_count >= 1 && request.space_count <= kMaxSpaceTypes)) return "space_count is not in 1..8";
  return Problem(request.headset);
}

const char* Problem(const BasePose& base_pose) noexcept {
  if (base_pose.known > 1 || base_pose.doubtful > 1 || base_pose.follows > 1) {
    return "known, doubtful or follows is neither 0 nor 1";
  }
  if (base_pose.uncalibrated > Uncalibrated::kOff) return "uncalibrated is not 0, 1 or 2";
  if (!(base_pose.expected_error_m >= 0 && base_pose.expected_error_m <= 1)) return "expected_error_m is not in 0..1";
  if (!(base_pose.rotation_sigma_rad >= 0 && base_pose.rotation_sigma_rad <= 4)) {
    return "rotation_sigma_rad is not in 0..4";
  }
  return PoseProblem(base_pose.base_space);
}

const char* Problem(const SpaceChange& change) noexcept {
  if (change.pose_valid > 1) return "pose_valid is neither 0 nor 1";
  return change.pose_valid == 1 ? PoseProblem(change.new_in_previous) : nullptr;
}

const char* Problem(const BasePoseCommand& command) noexcept {
  if (command.action < BasePoseAction::kStore || command.action > BasePoseAction::kCheck) {
    return "action is not in 1..5";
  }
  if (command.correct > 1) return "correct is neither 0 nor 1";
  if (command.uncalibrated > Uncalibrated::kOff) return "uncalibrated is not 0, 1 or 2";
  if (!IsTerminated(command.method)) return "method is not terminated";
  for (const double x : {command.rms_m, command.expected_error_m}) {
    if (!(x >= 0 && x <= 1)) return "rms_m or expected_error_m is not in 0..1";
  }
  if (!(command.rotation_sigma_rad >= 0 && command.rotation_sigma_rad <= 4)) return "rotation_sigma_rad is not in 0..4";
  if (const char* problem = Problem(command.headset)) return problem;
  return PoseProblem(command.base_space);
}

const char* Problem(const BaseMotion& motion) noexcept {
  if (motion.state > BaseState::kStands) return "state is not 0, 1 or 2";
  if (!(motion.t_ns >= 0 && motion.t_ns <= kLatestTime_ns)) return "t_ns is not in 0..2^62";
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(motion.linear_velocity_m_s[i]) <= kFastestWireBase_m_s)) {
      return "linear_velocity_m_s is not within 100 m/s";
    }
    if (!(std::abs(motion.angular_velocity_rad_s[i]) <= kFastestWireTurn_rad_s)) {
      return "angular_velocity_rad_s is not within 100 rad/s";
    }
  }
  if (const char* problem = Problem(motion.headset)) return problem;
  return PoseProblem(motion.base_space);
}

const char* Problem(const BasePoseReply& reply) noexcept {
  if (reply.done > 1) return "done is neither 0 nor 1";
  return IsTerminated(reply.text) ? nullptr : "text is not terminated";
}

const char* Problem(const Waveform& waveform) noexcept {
  const bool envelope = waveform.kind == WaveformKind::kEnvelope;
  if (!envelope && waveform.kind != WaveformKind::kPcm) return "kind is neither 1 nor 2";
  if (!(waveform.count >= 1 && waveform.count <= kMaxWaveformSamples)) return "count is not in 1..4000";
  if (waveform.append > 1) return "append is neither 0 nor 1";
  if (envelope) {
    if (!(waveform.duration_ns >= kShortestPulse_ns)) return "duration_ns is below -1";
    return waveform.sample_rate_Hz == 0 && waveform.append == 0 ? nullptr : "an envelope with a sample rate or append";
  }
  if (waveform.duration_ns != 0) return "PCM with a duration_ns";
  const bool rate_ok = waveform.sample_rate_Hz > 0 && waveform.sample_rate_Hz <= kHighestSampleRate_Hz;
  return rate_ok ? nullptr : "sample_rate_Hz is not above 0 and at most 1e5";
}

// A message of fixed size. False: `why` says what is wrong.
template <class T>
bool Decode(const void* bytes, std::size_t size, T& message, Invalid& why) noexcept {
  const char* name = Traits<T>::kName;
  if (size != sizeof(T)) return why = Because("%s of %zu bytes, must be %zu", name, size, sizeof(T)), false;
  std::memcpy(static_cast<void*>(&message), bytes, sizeof(T));
  const char* problem = Problem(message);
  if (problem != nullptr) why = Because("%s: %s", name, problem);
  return problem == nullptr;
}

// The structure at the start of a message that has a tail.
template <class Head>
bool DecodeHead(const char* name, const void* bytes, std::size_t size, Head& head, Invalid& why) noexcept {
  if (size < sizeof(head))
    return why = Because("%s of %zu bytes, must be at least %zu", name, size, sizeof(head)), false;
  std::memcpy(static_cast<void*>(&head), bytes, sizeof(head));
  const char* problem = Problem(head);
  if (problem != nullptr) why = Because("%s: %s", name, problem);
  return problem == nullptr;
}

std::string_view TextBehind(const void* bytes, std::size_t size, std::size_t head_bytes) noexcept {
  return {static_cast<const char*>(bytes) + head_bytes, size - head_bytes};
}

bool Decode(const void* bytes, std::size_t size, StatusReply& reply, Invalid& /*why*/) noexcept {
  reply.json = TextBehind(bytes, size, sizeof(MessageHeader));
  return true;
}

bool Decode(const void* bytes, std::size_t size, SceneAnswer& answer, Invalid& why) noexcept {
  if (!DecodeHead("SceneReply", bytes, size, answer.reply, why)) return false;
  answer.text = TextBehind(bytes, size, sizeof(answer.reply));
  return true;
}

bool Decode(const void* bytes, std::size_t size, HapticSceneNews& news, Invalid& why) noexcept {
  if (!DecodeHead("HapticSceneState", bytes, size, news.state, why)) return false;
  news.text = TextBehind(bytes, size, sizeof(news.state));
  return true;
}

bool Decode(const void* bytes, std::size_t size, HapticSceneRows& rows, Invalid& why) noexcept {
  const char* name = Traits<HapticSceneRows>::kName;
  if (!DecodeHead(name, bytes, size, rows.table, why)) return false;
  const std::size_t needed = sizeof(rows.table) + rows.table.node_count * sizeof(HapticNodeRow) +
                             rows.table.material_count * sizeof(base::MaterialParameters);
  if (size != needed) return why = Because("%s of %zu bytes, must be %zu", name, size, needed), false;
  rows.rows = static_cast<const std::byte*>(bytes) + sizeof(rows.table);
  for (std::uint32_t i = 0; i < rows.table.node_count; ++i) {
    const char* problem = Problem(rows.Node(i));
    if (problem != nullptr) return why = Because("%s: node %u: %s", name, i, problem), false;
  }
  for (std::uint32_t i = 0; i < rows.table.material_count; ++i) {
    const char* problem = protocol::Problem(rows.Material(i));
    if (problem != nullptr) return why = Because("%s: material %u: %s", name, i, problem), false;
  }
  return true;
}

bool Decode(const void* bytes, std::size_t size, ShapedHaptic& haptic, Invalid& why) noexcept {
  const char* name = Traits<ShapedHaptic>::kName;
  Waveform& waveform = haptic.waveform;
  if (!DecodeHead(name, bytes, size, waveform, why)) return false;
  const std::size_t expected = sizeof(waveform) + sizeof(float) * waveform.count;
  if (size != expected) return why = Because("%s of %zu bytes, must be %zu", name, size, expected), false;
  haptic.bytes = TextBehind(bytes, size, sizeof(waveform));
  const float least = waveform.kind == WaveformKind::kPcm ? -1.0f : 0.0f;
  for (std::uint32_t i = 0; i < waveform.count; ++i) {
    const float value = haptic.sample(i);
    if (!(value >= least && value <= 1.0f)) return why = Because("%s: sample %u is out of range", name, i), false;
  }
  return true;
}

struct TypeRow {
  MessageType type;
  const char* name;
  std::uint32_t roles;  // 0: of the server
  Delivery delivery;
};
constexpr TypeRow kTypes[] = {
#define OMNI_CLIENT_ROW(name, number, received, roles, pace, descriptors) \
  {MessageType::k##name, #name, roles, Delivery::kOnce},
#define OMNI_SERVER_ROW(name, number, received, delivery, descriptors) {MessageType::k##name, #name, 0, delivery},
    OMNI_LINK_MESSAGES(OMNI_CLIENT_ROW) OMNI_REQUESTS(OMNI_CLIENT_ROW) OMNI_SERVER_MESSAGES(OMNI_SERVER_ROW)
#undef OMNI_CLIENT_ROW
#undef OMNI_SERVER_ROW
};

const TypeRow* FindType(MessageType type) noexcept {
  for (const TypeRow& row : kTypes) {
    if (row.type == type) return &row;
  }
  return nullptr;
}

// Checks the header, before the message itself. True: it is valid.
bool CheckHeader(const void* bytes, std::size_t size, MessageHeader& header, Invalid& why) noexcept {
  if (size < sizeof(header)) return why = Because("a packet of %zu bytes is shorter than a header", size), false;
  if (size > kMaxMessageBytes) {
    return why = Because("a packet of %zu bytes, the limit is %zu", size, kMaxMessageBytes), false;
  }
  std::memcpy(&header, bytes, sizeof(header));
  if (header.magic != kMessageMagic) {
    return why = Because("magic 0x%08x, must be 0x%08x", header.magic, kMessageMagic), false;
  }
  if (header.size != size) return why = Because("header says %u bytes, the packet has %zu", header.size, size), false;
  if (header.version != kProtocolVersion && header.type != MessageType::kReject) {
    why = Because("protocol version %u, must be %u", header.version, kProtocolVersion);
    why.other_version = true;
    why.version = header.version;
    return false;
  }
  return true;
}

template <class Variant, class M>
Variant DecodeAs(const void* bytes, std::size_t size) noexcept {
  M message;
  Invalid why;
  if (!Decode(bytes, size, message, why)) return why;
  return message;
}

// The alternative of the header's type.
template <class... M>
std::variant<Invalid, M...> ValidateAs(const void* bytes, std::size_t size,
                                       const std::variant<Invalid, M...>* /*result*/) noexcept {
  using Variant = std::variant<Invalid, M...>;
  struct Decoder {
    MessageType type;
    Variant (*decode)(const void* bytes, std::size_t size) noexcept;
  };
  static constexpr Decoder kDecoders[] = {{Traits<M>::kType, DecodeAs<Variant, M>}...};
  MessageHeader header;
  Invalid why;
  if (!CheckHeader(bytes, size, header, why)) return why;
  for (const Decoder& decoder : kDecoders) {
    if (decoder.type == header.type) return decoder.decode(bytes, size);
  }
  const TypeRow* row = FindType(header.type);
  if (row == nullptr) return Because("message type %u is unknown", static_cast<unsigned>(header.type));
  return Because("%s, a message that only %s", row->name, row->roles == 0 ? "omnid sends" : "clients send");
}

}  // namespace

HapticNodeRow HapticSceneRows::Node(std::uint32_t i) const noexcept {
  HapticNodeRow row;
  std::memcpy(static_cast<void*>(&row), rows + i * sizeof(row), sizeof(row));
  return row;
}

base::MaterialParameters HapticSceneRows::Material(std::uint32_t i) const noexcept {
  base::MaterialParameters parameters;
  std::memcpy(static_cast<void*>(&parameters), rows + table.node_count * sizeof(HapticNodeRow) + i * sizeof(parameters),
              sizeof(parameters));
  return parameters;
}

ClientMessage ValidateFromClient(const void* bytes, std::size_t size) noexcept {
  return ValidateAs(bytes, size, static_cast<const ClientMessage*>(nullptr));
}

ServerMessage ValidateFromServer(const void* bytes, std::size_t size) noexcept {
  return ValidateAs(bytes, size, static_cast<const ServerMessage*>(nullptr));
}

Message Validate(const void* bytes, std::size_t size) noexcept {
  return ValidateAs(bytes, size, static_cast<const Message*>(nullptr));
}

const char* TypeName(MessageType type) noexcept {
  const TypeRow* row = FindType(type);
  return row == nullptr ? "unknown" : row->name;
}

std::uint32_t RolesOf(MessageType type) noexcept {
  const TypeRow* row = FindType(type);
  return row == nullptr ? 0 : row->roles;
}

Delivery DeliveryOf(MessageType type) noexcept {
  const TypeRow* row = FindType(type);
  return row == nullptr ? Delivery::kOnce : row->delivery;
}

}  // namespace omni::protocol
