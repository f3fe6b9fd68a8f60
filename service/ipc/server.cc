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
  // Signals are the main thread's business: a new thread inherits the mask of its maker.
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

std::int64_t Server::LastBeat_ns(ClientId id) const {
  const Peer* peer = impl_->loop->Find(id);
  return peer != nullptr ? peer->last_beat_ns() : 0;
}

void Server::SendNotice(ClientId id, int level, const std::string& text) { impl_->loop->SendNotice(id, level, text); }

void Server::SendSettings(ClientId id, const protocol::AppSettings& settings) {
  impl_->loop->SendSettings(id, settings);
}

bool Server::SendSurfaces(ClientId id, const protocol::Surfaces& surfaces, int fd) {
  return impl_->loop->SendSurfaces(id, surfaces, fd);
}

void Server::SendSceneReply(ClientId id, const SceneReplyParts& parts) { impl_->loop->SendSceneReply(id, parts); }

bool Server::SendForceOwner(ClientId id, const protocol::ForceOwner& owner) {
  return impl_->loop->SendAgainLater(id, &owner, sizeof(owner));
}

bool Server::SendForceProperties(ClientId id, const protocol::ForceProperties& properties) {
  return impl_->loop->SendAgainLater(id, &properties, sizeof(properties));
}

bool Server::TrySend(ClientId id, const void* message, std::size_t bytes) {
  return impl_->loop->SendAgainLater(id, message, bytes);
}

bool Server::SendPlacement(ClientId id, const protocol::Placement& placement) {
  return impl_->loop->SendPlacement(id, placement);
}

void Server::SendPlacementReply(ClientId id, std::uint32_t number, bool done, const std::string& text) {
  impl_->loop->SendPlacementReply(id, number, done, text);
}

std::uint64_t Server::DroppedMessages(ClientId id) const {
  const Peer* peer = impl_->loop->Find(id);
  return peer != nullptr ? peer->dropped() : 0;
}

const std::string& Server::socket_path() const { return impl_->loop->path(); }

}  // namespace omni::ipc
