// The control plane: one epoll thread that owns the socket, the clients and their signs of life.
// Never on the tick thread. Decides nothing about force: it reports to a ServerHandler.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/protocol/messages.h"
#include "service/protocol/state_memory.h"

namespace omni::ipc {

using ClientId = std::uint64_t;

struct ClientInfo {
  ClientId id = 0;
  protocol::ClientRole role = protocol::ClientRole::kApplication;
  int pid = 0;
  std::string application;
  std::string engine;
};

// Called on the control thread only. Calls must be short. A call that throws ends the connection of the client that
// caused it, and nothing else. Stop() makes no OnGone calls.
class ServerHandler {
 public:
  virtual ~ServerHandler() = default;
  virtual void OnClient(const ClientInfo& client) = 0;
  virtual void OnGone(ClientId id) = 0;  // socket end, process death (pidfd), or protocol error
  // A client's message that its role may send. Views in it are valid during the call. `file`: the descriptor of a
  // message that has one, checked: a HapticSceneLoad's is sealed memory of load.bytes bytes.
  virtual void OnRequest(ClientId id, const protocol::Request& request, base::UniqueFd file) = 0;
  // Every period (about 10 ms).
  virtual void OnPeriod(std::int64_t now_ns) = 0;
  virtual std::string StatusJson() = 0;
};

struct ServerOptions {
  std::string socket_path;  // empty: same rule as client::DefaultSocketPath
  int inherited_fd = -1;    // listens on socket_path already (ipc/listener.h); becomes the server's. < 0: it binds
  std::int64_t period_ns = 10'000'000;
  int max_clients = 32;                           // further ones are rejected with a reason
  std::uint64_t service_instance = 0;             // the one of the state memory, not 0
  int state_fd = -1;                              // StatePublisher::fd(): passed to every client; stays the caller's
  std::int64_t hello_timeout_ns = 2'000'000'000;  // a connection that stays silent longer is closed
  std::function<void()> on_start{};               // the control thread's first call
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
  void Stop();   // cannot be started again

  // Control thread only (from within handler calls).
  // The client's sign of life; null: unknown client. The page stays mapped while it is held, also after OnGone. Its
  // seals fix its size: whatever the client does to it, reading it raises no signal.
  std::shared_ptr<const protocol::LifePage> LifePageOf(ClientId id) const;
  // One of OMNI_SERVER_MESSAGES, followed by `tail`, truncated to what a message holds. `file`: descriptor to pass
  // along, still owned by the caller; < 0: none. False: not sent, because the client's socket is full or it is gone. A
  // message of Delivery::kOnce is then lost, and counted.
  template <class M>
  bool Send(ClientId id, const M& message, std::string_view tail = {}, int file = -1) {
    static_assert(offsetof(M, header) == 0);
    return Send(id, message.header, sizeof(M), tail, file);
  }
  // A whole message, header included.
  bool SendBytes(ClientId id, std::string_view message);
  // Messages to this client that were dropped because it does not read.
  std::uint64_t DroppedMessages(ClientId id) const;

  const std::string& socket_path() const;

 private:
  bool Send(ClientId id, const protocol::MessageHeader& head, std::size_t head_bytes, std::string_view tail, int file);

  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace omni::ipc
