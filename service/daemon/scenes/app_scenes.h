// Scenes that applications provide themselves (XR_OMNIX1_haptic_scene): at most one per client, built by the builder,
// active in place of the client's scene from apps.d. All on the control thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "service/daemon/devices/attached_device.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/ipc/server.h"
#include "service/loop/scene_motion.h"
#include "service/protocol/haptic_scene.h"

namespace omni::daemon {

class AppScenes {
 public:
  // Sends a whole message to a client; false: its socket is full, and it is sent in the next period.
  using Send = std::function<bool(ipc::ClientId id, const std::string& message)>;

  // What stops being a client's scene is retired by `handed`. Both outlive this.
  AppScenes(SceneBuilder& builder, double hull_radius_m, double tip_radius_m, HandOver<BuiltScene>& handed, Send send)
      : builder_(builder),
        hull_radius_m_(hull_radius_m),
        tip_radius_m_(tip_radius_m),
        handed_(handed),
        send_(std::move(send)) {}

  // Job numbers of these scenes, apart from those of the clients' scenes from apps.d.
  static constexpr std::uint64_t kJobBit = std::uint64_t{1} << 63;
  static bool IsJob(std::uint64_t job) noexcept { return (job & kJobBit) != 0; }
  static ipc::ClientId ClientOf(std::uint64_t job) noexcept { return job & ~kJobBit; }
  static std::uint64_t JobOf(ipc::ClientId id) noexcept { return id | kJobBit; }

  // Messages of a client. False: about a scene that no longer exists, nothing has changed.
  void Load(ipc::ClientId id, const std::string& application, const protocol::HapticSceneLoad& load,
            base::UniqueFd document);
  bool End(ipc::ClientId id, std::uint32_t number);
  bool Place(ipc::ClientId id, const protocol::HapticScenePlace& place);
  bool Enable(ipc::ClientId id, const protocol::HapticSceneEnable& enable);
  bool MoveNodes(ipc::ClientId id, const protocol::HapticNodes& nodes);
  bool SetMaterial(ipc::ClientId id, const protocol::HapticMaterial& material);
  void Remove(ipc::ClientId id);

  // Handles a result of the builder for one of these jobs. The scene that is active from now on, for the log and for
  // sculpting; null: there is none, see built.error.
  std::shared_ptr<const BuiltScene> Accept(BuiltScene built);

  // It has been ready once: from then on the client's scene from apps.d is not used.
  bool HasBeenReady(ipc::ClientId id) const;
  // Null: none, because it is not enabled.
  std::shared_ptr<const BuiltScene> ActiveScene(ipc::ClientId id) const;
  bool Contains(const std::shared_ptr<const BuiltScene>& scene) const;
  // Fills in what the tick needs. Precondition: HasBeenReady(id).
  void FillControl(ipc::ClientId id, std::uint64_t generation, loop::SceneControl& control) const;

  // Notifies every client of changes. `felt`: the client whose scene is active; `generation`: of that scene.
  void Notify(ipc::ClientId felt, std::uint64_t generation);

 private:
  struct AppScene {
    std::uint32_t number = 0;
    std::uint32_t flags = 0;
    std::string name;
    std::shared_ptr<const base::UniqueFd> document;
    double scale = 1;        // wanted
    double built_scale = 1;  // of `built`, or of what is being built
    bool loading = true, failed = false, enabled = true;
    std::int64_t asked_ns = 0, load_ns = 0;
    std::string text;
    std::shared_ptr<const BuiltScene> built;
    double felt_scale = 1;  // of `built`
    loop::SceneControl control;
    bool table_due = false;
    std::optional<protocol::HapticSceneState> reported;
  };
  AppScene* Find(ipc::ClientId id, std::uint32_t number);
  void Request(ipc::ClientId id, AppScene& scene);
  void Drop(AppScene& scene);
  protocol::HapticSceneState StateOf(const AppScene& scene, std::uint64_t generation) const;

  SceneBuilder& builder_;
  const double hull_radius_m_, tip_radius_m_;
  HandOver<BuiltScene>& handed_;
  const Send send_;
  std::map<ipc::ClientId, AppScene> scenes_;
  std::uint64_t samples_ = 0;  // poses received so far
};

// A whole message with the rows that describe a scene to its client.
std::string HapticTableMessage(std::uint32_t number, const BuiltScene& built);

}  // namespace omni::daemon
