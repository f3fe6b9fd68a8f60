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
#include "service/protocol/control.h"
#include "service/protocol/waveform.h"

namespace omni::client {

struct ConnectionInfo {
  protocol::ClientRole role = protocol::ClientRole::kApplication;
  std::string application;
  std::string engine;
  std::uint32_t api_version_major = 1;
  std::uint32_t api_version_minor = 0;
  std::string socket_path;                       // empty: DefaultSocketPath()
  std::int64_t retry_interval_ns = 500'000'000;  // between attempts to connect
};

// $OMNI_SOCKET, else $XDG_RUNTIME_DIR/omni/omnid.sock, else /tmp/omni-<uid>/omnid.sock.
std::string DefaultSocketPath();

// The answer to a scene command.
struct SceneAnswer {
  std::uint32_t number = 0;  // that SendSceneCommand returned
  bool done = false;         // false: refused, `text` says why
  std::string text;          // kEdits: JSON; else a line for people
  std::string file;          // kSave: bytes of a .glb
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
  void Beat() noexcept;

  // False: not connected or the socket is full (the message is dropped; session states are sent again on reconnection).
  bool SendSession(protocol::SessionState state) noexcept;
  bool SendHaptic(std::int64_t duration_ns, float amplitude, float frequency_Hz) noexcept;
  bool SendHapticStop() noexcept;
  // `waveform`: all but header and count, which follow from the samples, 1 to protocol::kMaxWaveformSamples of them.
  // Samples are clamped to their range. False also: one is not a number, or a field is out of range.
  bool SendWaveform(const protocol::Waveform& waveform, std::span<const float> samples) noexcept;
  bool RequestStatus() noexcept;

  // Asks for the surfaces that change shape or place, or no longer; asked again on reconnection. Nothing is computed
  // while nobody asks.
  bool RequestSurfaces(bool wanted) noexcept;
  // The newest memory announced; another one after a change of scene, or when a sculpted surface has outgrown it. Null:
  // not asked, not answered yet, or nothing changes. Lives as long as the caller holds it.
  std::shared_ptr<const SurfaceReader> surfaces() const noexcept;
  // The newest request was answered, if only with "nothing".
  bool surfaces_answered() const noexcept;

  // Number of the command, which its answer bears; 0: not sent. `object` longer than the field is cut.
  std::uint32_t SendSceneCommand(protocol::SceneAction action, std::uint64_t client_id, const std::string& object);
  // Newest answer to a scene command; taking it clears it.
  std::optional<SceneAnswer> TakeSceneAnswer();

  // Newest answer to RequestStatus (JSON), empty if none yet; taking it clears it.
  std::string TakeStatus();
  // Notices received since the last call.
  std::vector<protocol::Notice> TakeNotices();
  // Why the last attempt failed: names the path and what to do. Empty when connected.
  const std::string& last_error() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace omni::client
