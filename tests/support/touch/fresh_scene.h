// A scene to be touched repeatedly from its initial state. A sculptable one changes under the pen: a copy of the
// initial state is edited by the service's own thread.
#pragma once

#include <memory>

#include "service/daemon/scenes/sculpt_thread.h"
#include "service/haptics/scene/scene.h"

namespace omni::test {

// The scene as it was before it was sculpted: new sculpt sessions, the same soft bodies. A scene without them shares
// its live parts with the copy.
haptics::Scene FreshCopy(const haptics::Scene& scene);

class FreshScene {
 public:
  // `original` outlives this and is not changed.
  explicit FreshScene(const haptics::Scene& original);
  ~FreshScene();
  FreshScene(const FreshScene&) = delete;
  FreshScene& operator=(const FreshScene&) = delete;

  // Restores the untouched state. Free for a scene that cannot be sculpted; else it may take a second. Not in a tick:
  // scene() is another one afterwards.
  void Renew();
  const haptics::Scene& scene() const { return *scene_; }

 private:
  void Drop();

  const haptics::Scene& original_;
  const haptics::Scene* scene_;
  std::shared_ptr<const haptics::Scene> copy_;  // null: the original is used
  daemon::SculptThread editor_;
};

}  // namespace omni::test
