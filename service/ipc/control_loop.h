// The epoll loop of the control thread: accepts, reads, keeps time, and calls the handler.
#pragma once

#include <atomic>
#include <exception>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "service/ipc/listener.h"
#include "service/ipc/peer.h"
#include "service/ipc/server.h"
#include "service/protocol/messages.h"

namespace omni::ipc {

class ControlLoop {
 public:
  static base::Result<std::unique_ptr<ControlLoop>> Open(const ServerOptions& options, ServerHandler& handler);
  ControlLoop(const ControlLoop&) = delete;
  ControlLoop& operator=(const ControlLoop&) = delete;

  void Run();          // until RequestStop
  void RequestStop();  // any thread
  const std::string& path() const { return listener_.path(); }

  // Control thread only; null: unknown.
  const Peer* Find(ClientId id) const;
  // As Server's.
  bool Send(ClientId id, const protocol::MessageHeader& head, std::size_t head_bytes, std::string_view tail, int file);
  bool SendBytes(ClientId id, std::string_view message, int file);

 private:
  ControlLoop(const ServerOptions& options, ServerHandler& handler, Listener listener);
  base::Status OpenDescriptors();
  base::Status Watch(int fd, std::uint64_t token);

  void Dispatch(std::uint64_t token);
  void Accept();
  void RefuseOneWithoutDescriptors();
  void Admit(base::UniqueFd socket);
  void ReadFrom(Peer& peer);
  // One message; `file`: the descriptor that came with it. True: this peer may be read again in this round.
  bool Handle(Peer& peer, const protocol::ClientMessage& message, base::UniqueFd file);
  template <class M>
  void HandleAs(Peer& peer, const M& message, base::UniqueFd file);
  void Greet(Peer& peer, const protocol::Hello& hello);
  void AnswerStatus(Peer& peer);
  void OnTimer();
  void Refuse(Peer& peer, const std::string& reason);
  void Sweep();
  std::size_t CountGreeted() const;

  // Runs a handler call; what it throws is logged, and dooms `peer` if there is one.
  template <class Call>
  void Guarded(const char* name, Peer* peer, Call&& call) {
    try {
      return call();
    } catch (const std::exception& error) {
      ReportThrow(name, peer, error.what());
    } catch (...) {
      ReportThrow(name, peer, "an unknown exception");
    }
  }
  void ReportThrow(const char* name, Peer* peer, const std::string& what);

  ServerOptions options_;
  ServerHandler& handler_;
  Listener listener_;
  LogLines log_;
  base::UniqueFd epoll_;
  base::UniqueFd timer_;
  base::UniqueFd stop_;
  base::UniqueFd spare_;  // given up for a moment to refuse a client when descriptors have run out
  std::atomic<bool> stopping_{false};
  std::map<ClientId, Peer> peers_;
  ClientId next_id_ = 1;
  std::vector<std::byte> buffer_;
};

}  // namespace omni::ipc
