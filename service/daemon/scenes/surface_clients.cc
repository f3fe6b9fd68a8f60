#include "service/daemon/scenes/surface_clients.h"

#include <utility>

namespace omni::daemon {

SurfaceClients::SurfaceClients(std::uint64_t service_instance, Snapshot snapshot, Send send)
    : service_instance_(service_instance), snapshot_(std::move(snapshot)), send_(std::move(send)) {}

void SurfaceClients::HandleRequest(ipc::ClientId id, bool wanted) {
  if (wanted) {
    reported_[id] = std::nullopt;
  } else {
    reported_.erase(id);
  }
}

void SurfaceClients::Remove(ipc::ClientId id) { reported_.erase(id); }

std::string SurfaceClients::Update(const std::shared_ptr<const haptics::Scene>& scene, std::uint64_t scene_generation) {
  const bool needed = !reported_.empty() && scene != nullptr && !haptics::ChangingObjects(*scene).empty();
  KeepThread(scene, scene_generation, needed);
  if (!needed) {
    Announce(nullptr);
    return {};
  }
  if (thread_ == nullptr || is_ending_) return {};
  const std::string problem = thread_->problem();
  const auto memory = thread_->memory();
  if (memory != nullptr || !problem.empty()) Announce(memory.get());
  return problem != std::exchange(problem_, problem) ? problem : std::string();
}

// A thread that was asked to end is joined only once it has ended: this one must not wait for a poll of a large
// surface. Clients that request surfaces meanwhile get a new thread after it. One that ended with a problem is kept, so
// that the same scene is not tried again.
void SurfaceClients::KeepThread(const std::shared_ptr<const haptics::Scene>& scene, std::uint64_t scene_generation,
                                bool needed) {
  if (thread_ != nullptr && (!needed || thread_generation_ != scene_generation)) {
    thread_->RequestStop();
    is_ending_ = true;
  }
  if (thread_ != nullptr && is_ending_ && thread_->finished()) thread_ = nullptr;
  if (!needed || thread_ != nullptr) return;
  is_ending_ = false;
  thread_generation_ = scene_generation;
  thread_ = std::make_unique<SurfaceThread>(SurfaceSource{.scene = scene,
                                                          .scene_generation = scene_generation,
                                                          .service_instance = service_instance_,
                                                          .snapshot = snapshot_,
                                                          .memory_generation = &memory_generation_});
}

// Notifies clients of a change. A message that cannot be sent is tried again in the next period.
void SurfaceClients::Announce(const ipc::SurfacePublisher* memory) {
  protocol::Surfaces message;
  if (memory != nullptr) {
    message.total_bytes = memory->bytes();
    message.memory_generation = memory->id().memory_generation;
  }
  for (auto& [id, reported] : reported_) {
    if (reported == message.memory_generation) continue;
    if (send_(id, message, memory == nullptr ? -1 : memory->fd())) reported = message.memory_generation;
  }
}

}  // namespace omni::daemon
