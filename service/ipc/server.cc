#include "service/ipc/server.h"

#include <pthread.h>

#include <csignal>
#include <thread>
#include <utility>

#include "service/ipc/control_loop.h"
#include "service/protocol/socket_path.h"

namespace omni::ipc {

struct Server::Impl {
  std::unique_ptr<ControlLoop> loop;
  std::thread thread;
};

base::Result<std::unique_ptr<Server>> Server::Open(const ServerOptions& options, ServerHandler& handler) {
  ServerOptions resolved = options;
  if (resolved.socket_path.empty()) resolved.socket_path = protocol::DefaultSocketPath();
  auto loop = ControlLoop::Open(resolved, handler);
  if (!loop) return base::Error{loop.error()};
  auto impl = std::make_unique<Impl>();
  impl->loop = std::move(*loop);
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() { Stop(); }

void Server::Start() {
  // The main thread handles signals: a new thread inherits the mask of its creator.
  sigset_t all;
  sigset_t previous;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &previous);
  impl_->thread = std::thread([loop = impl_->loop.get()] { loop->Run(); });
  pthread_sigmask(SIG_SETMASK, &previous, nullptr);
}

void Server::Stop() {
  impl_->loop->RequestStop();
  if (impl_->thread.joinable() && impl_->thread.get_id() != std::this_thread::get_id()) impl_->thread.join();
}

std::shared_ptr<const protocol::LifePage> Server::LifePageOf(ClientId id) const {
  const Peer* peer = impl_->loop->Find(id);
  return peer != nullptr ? peer->life() : nullptr;
}

bool Server::Send(ClientId id, const protocol::MessageHeader& head, std::size_t head_bytes, std::string_view tail,
                  int file) {
  return impl_->loop->Send(id, head, head_bytes, tail, file);
}

bool Server::SendBytes(ClientId id, std::string_view message) { return impl_->loop->SendBytes(id, message, -1); }

std::uint64_t Server::DroppedMessages(ClientId id) const {
  const Peer* peer = impl_->loop->Find(id);
  return peer != nullptr ? peer->dropped() : 0;
}

const std::string& Server::socket_path() const { return impl_->loop->path(); }

}  // namespace omni::ipc
