// A client's link to omnid: control socket and state memory. Starts no thread, never blocks.
// Not thread safe (guard Poll and Send* with one mutex); StateReader is safe from any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "service/client/state_reader.h"
#include "service/client/surface_reader.h"
#include "service/protocol/base_pose.h"
#include "service/protocol/control.h"
#include "service/protocol/environment.h"
#include "service/protocol/force_feedback.h"
#include "service/protocol/haptic_scene.h"
#include "service/protocol/waveform.h"

namespace omni::client {

// What omnid reports about an application's own scene (protocol/haptic_scene.h).
struct HapticSceneTable {
  std::uint32_t number = 0;
  std::vector<protocol::HapticNodeRow> nodes;  // row i is object i
  std::vector<base::MaterialParameters> materials;
};

// Either a state with its text, or a table.
struct HapticSceneUpdate {
  bool is_table = false;
  protocol::HapticSceneState state;
  std::string text;
  HapticSceneTable table;
};

struct ConnectionInfo {
  protocol::ClientRole role = protocol::ClientRole::kApplication;
  std::string application;
  std::string engine;
  std::uint32_t api_version_major = 1;
  std::uint32_t api_version_minor = 0;
  std::string socket_path;                       // empty: DefaultSocketPath()
  std::int64_t retry_interval_ns = 500'000'000;  // between attempts to connect
  // A privileged process connects only to an explicit socket_path: the default one depends on its caller's environment.
  bool privileged = protocol::IsPrivileged();
};

// protocol::DefaultSocketPath()
std::string DefaultSocketPath();

// The answer to a scene command.
struct SceneAnswer {
  std::uint32_t number = 0;  // that SendSceneCommand returned
  bool done = false;         // false: refused, `text` says why
  std::string text;          // kEdits: JSON; else a line for people
  std::string file;          // kSave: bytes of a .glb
};

// The answer to a base pose command.
struct BasePoseAnswer {
  std::uint32_t number = 0;  // that SendBasePoseCommand returned
  bool done = false;         // false: refused
  std::string text;          // for people
};

class Connection {
 public:
  explicit Connection(ConnectionInfo info);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Connects when due, reads what has arrived. Bounded work, no blocking call. After a lost connection it retries.
  // On (re)connection the last session state is sent again.
  void Poll(std::int64_t now_ns) noexcept;

  bool connected() const noexcept;  // welcomed, state memory mapped

  // Null while not connected. The reader (and its mapping) lives as long as the caller holds it.
  std::shared_ptr<const StateReader> state() const noexcept;

  // Sign of life: one relaxed add into our own page. Any thread.
  void SignalAlive() noexcept;

  // One of OMNI_LINK_MESSAGES or OMNI_REQUESTS (protocol/message_table.h). `file`: descriptor to pass along, still
  // owned by the caller; < 0: none. False: not sent, because this client is not connected, its role may not send it, it
  // is out of range (the service would end the connection), or the socket is full.
  template <class M>
  bool Send(const M& message, int file = -1) noexcept {
    return SendBytes({reinterpret_cast<const char*>(&message), sizeof(message)}, file);
  }

  // The session's state; sent again on reconnection. False: the service does not know it yet.
  bool SendSession(protocol::SessionState state) noexcept;
  bool SendHaptic(std::int64_t duration_ns, float amplitude, float frequency_Hz) noexcept;
  // `waveform`: all but header and count, which follow from the samples, 1 to protocol::kMaxWaveformSamples of them.
  // Samples are clamped to their range. False also if a sample is NaN or a field is out of range.
  bool SendWaveform(const protocol::Waveform& waveform, std::span<const float> samples) noexcept;

  // Claims the pen for forces, or gives it up; claimed again on reconnection.
  bool ClaimForce(bool wanted) noexcept;
  // As last reported by the service; while not connected: free, and nothing is available.
  protocol::ForceStanding force_standing() const noexcept;
  const protocol::ForceProperties& force_properties() const noexcept;
  // The service was reached, but has not reported what its device can do. False if there is no service.
  bool awaits_force_properties() const noexcept;

  // Requests the surfaces that change shape or place, or cancels the request; repeated on reconnection. Without a
  // request nothing is computed.
  bool RequestSurfaces(bool wanted) noexcept;
  // The newest memory announced; replaced after a change of scene, or when a sculpted surface outgrows it. Null: not
  // requested, not answered yet, or nothing changes. Lives as long as the caller holds it.
  std::shared_ptr<const SurfaceReader> surfaces() const noexcept;
  // The newest request was answered, if only with "nothing".
  bool surfaces_answered() const noexcept;

  // Number of the command, repeated in its answer; 0: not sent. An `object` longer than the field is truncated.
  std::uint32_t SendSceneCommand(protocol::SceneAction action, std::uint64_t client_id, const std::string& object);
  // Newest answer to a scene command; taking it clears it.
  std::optional<SceneAnswer> PopSceneAnswer();

  // Number of connections made so far. This application's own scene is not sent again on reconnection: whoever keeps
  // the document checks this number and sends it.
  std::uint64_t welcomes() const noexcept;
  // Updates received since the last call, oldest first; at most kMaxHapticSceneUpdates are queued, older ones are
  // dropped.
  static constexpr std::size_t kMaxHapticSceneUpdates = 16;
  std::vector<HapticSceneUpdate> PopHapticSceneUpdates();
  // Requests the base's pose in one of these spaces; repeated on reconnection. The answer and every later change
  // arrive through PopBasePose. False: not connected yet, the request is sent on connection.
  bool RequestBasePose(const protocol::BasePoseRequest& request) noexcept;
  // The newest since the last call.
  std::optional<protocol::BasePose> PopBasePose() noexcept;
  // Number of the command, repeated in its answer; 0: not sent, or this client is not a tool. Sets `command.number`.
  std::uint32_t SendBasePoseCommand(protocol::BasePoseCommand command) noexcept;
  std::optional<BasePoseAnswer> PopBasePoseAnswer();

  // Newest answer to RequestStatus (JSON), empty if none yet; taking it clears it.
  std::string PopStatus();
  // Notices received since the last call.
  std::vector<protocol::Notice> PopNotices();
  // Settings last sent by the service, else the defaults. Kept when the connection is lost.
  const protocol::AppSettings& settings() const noexcept;
  // Why the last attempt failed: names the path and what to do. Empty when connected.
  const std::string& last_error() const noexcept;

 private:
  bool SendBytes(std::string_view message, int file) noexcept;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace omni::client
