// Which scene each client has: that of its file in apps.d, or one that it has handed over itself; and which of them the
// tick has. Scenes are built by processes of their own and sculpted on a thread; one is freed when neither its client
// nor the tick has it any more. Control thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "service/daemon/clients/clients.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/scenes/app_scenes.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/daemon/scenes/sculpt_thread.h"

namespace omni::daemon {

std::uint32_t TrianglesOf(const haptics::Scene& scene);

class ClientScenes {
 public:
  // For people: 0 a remark, 1 a warning, 2 an error. `id`: the client that gets it, too; 0: none.
  using Problem = std::function<void(ipc::ClientId id, int level, const std::string& text)>;

  // `say`: what may be over soon; the status has it while it lasts.
  ClientScenes(const BuilderOptions& options, Problem problem, Problem say, AppScenes::Send send);

  // Builds the scene of the client's file. `application`: its own name.
  void Request(ipc::ClientId id, const config::AppEntry& app, const std::string& application) {
    builder_.Request(id, app, application);
  }
  // The client no longer wants the scene of its file; Remove: is gone.
  void Drop(ipc::ClientId id);
  void Remove(ipc::ClientId id);
  // Those that clients hand over.
  AppScenes& documents() { return documents_; }
  SculptThread& sculpt() { return sculpt_; }
  // Once per period: what has been built, computed and sculpted meanwhile.
  void HandleResults();

  // The client's scene, active while it owns the force; null: none.
  std::shared_ptr<const BuiltScene> Of(ipc::ClientId id) const;
  // The soft bodies of a scene, null: none; of the client's, or of what is being built for it.
  SoftProgress ProgressOf(const BuiltScene* scene) const {
    return builder_.Progress(scene == nullptr ? 0 : scene->client);
  }
  SoftProgress ProgressOf(ipc::ClientId id) const;
  BuilderStatus BuilderNow() const { return builder_.Status(); }
  std::uint64_t KeptBytesOf(ipc::ClientId id) const { return builder_.KeptBytes(id); }
  scene::LoadOptions LoadOptionsFor(const config::AppEntry& app) const {
    return LoadOptionsOf(app, hull_radius_m_, tip_radius_m_);
  }

  // Makes the owner's scene, 0: none, the one that the tick is to have.
  void SetOwner(ipc::ClientId owner);
  // That one; null: none.
  const BuiltScene* felt() const { return handed_.newest().get(); }
  std::shared_ptr<const haptics::Scene> felt_scene() const { return felt() == nullptr ? nullptr : felt()->scene; }
  std::uint64_t generation() const { return handed_.number(); }
  loop::SceneControl ControlOf(ipc::ClientId owner) const;
  // `taken`: generation that the tick has acknowledged; none: there is no tick.
  void Release(std::optional<std::uint64_t> taken);

 private:
  void TakeFileScene(BuiltScene built);
  void TakeDocument(BuiltScene built);
  void ReportSoftBody(const SoftOutcome& soft);

  const double hull_radius_m_, tip_radius_m_;
  const Problem problem_, say_;
  SceneBuilder builder_;
  SculptThread sculpt_;
  HandOver<BuiltScene> handed_;
  std::map<ipc::ClientId, std::shared_ptr<const BuiltScene>> files_;  // of clients' files in apps.d
  AppScenes documents_;
};

}  // namespace omni::daemon
