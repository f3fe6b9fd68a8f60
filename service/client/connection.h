// A client's link to omnid: control socket and state memory. Starts no thread, never blocks.
// Not thread safe (guard Poll and Send* with one mutex); StateReader is safe from any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "service/client/state_reader.h"
#include "service/client/surface_reader.h"
#include "service/protocol/control.h"

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
  bool RequestStatus() noexcept;

  // Asks for the surfaces that change shape or place, or no longer; asked again on reconnection. Nothing is computed
  // while nobody asks.
  bool RequestSurfaces(bool wanted) noexcept;
  // The newest memory announced; another one after a change of scene, or when a sculpted surface has outgrown it. Null:
  // not asked, not answered yet, or nothing changes. Lives as long as the caller holds it.
  std::shared_ptr<const SurfaceReader> surfaces() const noexcept;
  // The newest request was answered, if only with "nothing".
  bool surfaces_answered() const noexcept;

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
