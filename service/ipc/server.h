// The control plane: one epoll thread that owns the socket, the clients and their signs of life.
// Never on the tick thread. Decides nothing about force: it reports to a ServerHandler.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/protocol/app_settings.h"
#include "service/protocol/control.h"
#include "service/protocol/force_feedback.h"
#include "service/protocol/haptic_scene.h"
#include "service/protocol/placement.h"
#include "service/protocol/waveform.h"

namespace omni::ipc {

using ClientId = std::uint64_t;

struct ClientInfo {
  ClientId id = 0;
  protocol::ClientRole role = protocol::ClientRole::kApplication;
  int pid = 0;
  std::string application;
  std::string engine;
};

// The answer to a SceneCommand.
struct SceneReplyParts {
  std::uint32_t number = 0;  // of the command
  bool done = false;
  std::string text;              // longer than a message: cut
  int file = -1;                 // descriptor that goes along if `done` and file_bytes > 0; stays the caller's
  std::uint64_t file_bytes = 0;  // its size
};

// Called on the control thread only. Calls must be short. A call that throws costs the client that caused it its
// connection, and nothing else. Stop() makes no OnGone calls.
class ServerHandler {
 public:
  virtual ~ServerHandler() = default;
  virtual void OnClient(const ClientInfo& client) = 0;
  virtual void OnGone(ClientId id) = 0;  // socket end, process death (pidfd), or protocol error
  virtual void OnSession(ClientId id, protocol::SessionState state) = 0;
  virtual void OnHaptic(ClientId id, const protocol::Haptic& haptic) = 0;
  virtual void OnHapticStop(ClientId id) = 0;
  // The samples are valid during the call.
  virtual void OnWaveform(ClientId /*id*/, const protocol::ShapedHaptic& /*haptic*/) {}
  // This client wants to draw surfaces that change, or no longer; it waits for SendSurfaces. Not overridden: there are
  // none, ever.
  virtual void OnSurfaceRequest(ClientId /*id*/, bool /*wanted*/) {}
  // To be answered by one SendSceneReply, now or later. Any client.
  virtual void OnSceneCommand(ClientId id, const protocol::SceneCommand& command) = 0;
  // An application's claim on the pen, its force, its constraints. Not overridden: nothing is felt.
  virtual void OnForce(ClientId /*id*/, const protocol::ForceRequest& /*request*/) {}
  // An application's own scene (protocol/haptic_scene.h). `document` is sealed memory of load.bytes bytes, checked. Not
  // overridden: there are none, ever.
  virtual void OnHapticSceneLoad(ClientId /*id*/, const protocol::HapticSceneLoad& /*load*/,
                                 base::UniqueFd /*document*/) {}
  virtual void OnHapticSceneEnd(ClientId /*id*/, const protocol::HapticSceneEnd& /*end*/) {}
  virtual void OnHapticScenePlace(ClientId /*id*/, const protocol::HapticScenePlace& /*place*/) {}
  virtual void OnHapticSceneEnable(ClientId /*id*/, const protocol::HapticSceneEnable& /*enable*/) {}
  virtual void OnHapticNodes(ClientId /*id*/, const protocol::HapticNodes& /*nodes*/) {}
  virtual void OnHapticMaterial(ClientId /*id*/, const protocol::HapticMaterial& /*material*/) {}
  // This application wants to know where the base stands in one of its spaces, now and whenever that changes; to be
  // answered by SendPlacement. Not overridden, as the next two: nobody knows.
  virtual void OnPlacementRequest(ClientId /*id*/, const protocol::PlacementRequest& /*request*/) {}
  // Its runtime moves a space.
  virtual void OnSpaceChange(ClientId /*id*/, const protocol::SpaceChange& /*change*/) {}
  // To be answered by one SendPlacementReply. Tools only.
  virtual void OnPlacementCommand(ClientId /*id*/, const protocol::PlacementCommand& /*command*/) {}
  // Every period (about 10 ms). last_beat_ns(id) tells when each client's life page last changed.
  virtual void OnPeriod(std::int64_t now_ns) = 0;
  virtual std::string StatusJson() = 0;
};

struct ServerOptions {
  std::string socket_path;  // empty: same rule as client::DefaultSocketPath
  std::int64_t period_ns = 10'000'000;
  int max_clients = 32;                           // further ones are rejected with a reason
  std::uint64_t service_instance = 0;             // the one of the state memory, not 0
  int state_fd = -1;                              // StatePublisher::fd(): passed to every client; stays the caller's
  std::int64_t hello_timeout_ns = 2'000'000'000;  // a connection that stays silent longer is closed
  // Lines for people (a client refused, a call that threw); empty: standard error. Control thread only.
  std::function<void(const std::string&)> log{};
};

class Server {
 public:
  // Makes the folder (0700, owned by us, no symlink; else refused), takes the lock file beside the socket (a second
  // omnid is refused with the pid of the first), binds and listens.
  static base::Result<std::unique_ptr<Server>> Open(const ServerOptions& options, ServerHandler& handler);
  ~Server();  // stops the thread, closes all
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  void Start();  // once
  void Stop();   // for good

  // Control thread only (from within handler calls).
  std::int64_t LastBeat_ns(ClientId id) const;  // 0: unknown client; read anew every period
  void SendNotice(ClientId id, int level, const std::string& text);
  void SendSettings(ClientId id, const protocol::AppSettings& settings);
  // False: it does not read now and the message was not sent, or it is gone. `fd` < 0: none goes along.
  bool SendSurfaces(ClientId id, const protocol::Surfaces& surfaces, int fd);
  void SendSceneReply(ClientId id, const SceneReplyParts& parts);
  // False: as SendSurfaces.
  bool SendForceOwner(ClientId id, const protocol::ForceOwner& owner);
  bool SendForceProperties(ClientId id, const protocol::ForceProperties& properties);
  // A whole message, header included, that is sent again later if it does not go out. False as for SendSurfaces.
  bool TrySend(ClientId id, const void* message, std::size_t bytes);
  // False: as above.
  bool SendPlacement(ClientId id, const protocol::Placement& placement);
  void SendPlacementReply(ClientId id, std::uint32_t number, bool done, const std::string& text);
  // Messages to this client that were dropped because it does not read.
  std::uint64_t DroppedMessages(ClientId id) const;

  const std::string& socket_path() const;

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace omni::ipc
