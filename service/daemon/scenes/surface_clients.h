// The clients that draw surfaces, and what was sent to them. Starts the surface thread when it is needed and ends it
// when it is not. Control thread only.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "service/daemon/scenes/surface_thread.h"
#include "service/haptics/scene/scene.h"
#include "service/ipc/server.h"

namespace omni::daemon {

class SurfaceClients {
 public:
  // The newest snapshot of the tick, as SurfaceSource::snapshot: called on the surface thread.
  using Snapshot = std::function<bool(loop::SurfaceSnapshot&)>;
  // ipc::Server::Send.
  using Send = std::function<bool(ipc::ClientId, const protocol::Surfaces&, int fd)>;

  SurfaceClients(std::uint64_t service_instance, Snapshot snapshot, Send send);

  // A repeated request counts, too: it is answered again.
  void HandleRequest(ipc::ClientId id, bool wanted);
  void Remove(ipc::ClientId id);

  // Once per period: the scene that the tick should have, null: none. Returns a new problem for people, or nothing.
  std::string Update(const std::shared_ptr<const haptics::Scene>& scene, std::uint64_t scene_generation);

  // There is a thread that reads snapshots.
  bool running() const noexcept { return thread_ != nullptr && !thread_->finished(); }

 private:
  void KeepThread(const std::shared_ptr<const haptics::Scene>& scene, std::uint64_t scene_generation, bool needed);
  void Announce(const ipc::SurfacePublisher* memory);

  const std::uint64_t service_instance_;
  const Snapshot snapshot_;
  const Send send_;
  std::map<ipc::ClientId, std::optional<std::uint64_t>> reported_;  // memory generation sent, 0: that there is none
  std::atomic<std::uint64_t> memory_generation_{0};
  std::string problem_;                  // newest, already reported
  std::uint64_t thread_generation_ = 0;  // of its scene
  std::unique_ptr<SurfaceThread> thread_;
  bool is_ending_ = false;  // the thread was asked to end: its memory is no longer updated
};

}  // namespace omni::daemon
