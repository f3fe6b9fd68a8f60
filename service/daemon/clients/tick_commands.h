// The commands that the tick gets, with the scene that they are about: what the owner of the force requests, and the
// owner's sign of life, without which the tick makes no force. Control thread only.
#pragma once

#include <cstdint>
#include <memory>

#include "service/daemon/clients/clients.h"
#include "service/daemon/clients/vibration.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/scenes/client_scenes.h"
#include "service/haptics/applied/applied.h"

namespace omni::daemon {

class TickCommands {
 public:
  // `fallback`: mapping of inputs for applications whose file has none. All three outlive this.
  TickCommands(AttachedDevice& device, const ClientScenes& scenes, const base::InputMapping& fallback)
      : device_(device), scenes_(scenes), fallback_(fallback) {}

  Vibration& vibration() { return vibration_; }
  const base::InputMapping& MappingOf(const Client* owner) const;

  struct Force {
    const Client* owner = nullptr;                   // null: none
    std::shared_ptr<const protocol::LifePage> life;  // the owner's; null: none
    bool allowed = false;
    haptics::AppliedCommand applied;
  };
  void Write(std::int64_t now_ns, Force force, bool idle);
  // What the tick has, without force: before anything that takes longer.
  void CloseGate();
  // Unmaps pages of earlier owners. `taken`: number of the page that the tick reads; none: there is no tick.
  void Release(std::optional<std::uint64_t> taken) { lives_.Release(taken); }

 private:
  AttachedDevice& device_;
  const ClientScenes& scenes_;
  const base::InputMapping& fallback_;
  Vibration vibration_;
  HandOver<protocol::LifePage> lives_;
  loop::Commands commands_;  // that the tick was given last
};

}  // namespace omni::daemon
