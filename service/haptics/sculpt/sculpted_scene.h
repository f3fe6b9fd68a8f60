// The sculpted surfaces of a whole scene: edited in the loop's own time, and as a scene of their own, for saving.
#pragma once

#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics::sculpt {

// Edits them as the service's thread does in real time (daemon/scenes/sculpt_thread.h): runs that play the same then
// give the same bits. A stroke that is refused changes nothing.
class VirtualEditor {
 public:
  static constexpr int kPeriod_ticks = 2;  // the service's 2 ms

  // Before the first tick of `scene`, which outlives this.
  explicit VirtualEditor(const Scene& scene) : live_(scene.live().get()) { SetReader(true); }
  // Ends open strokes.
  ~VirtualEditor() { SetReader(false); }
  VirtualEditor(const VirtualEditor&) = delete;
  VirtualEditor& operator=(const VirtualEditor&) = delete;

  // After each tick, on its thread. May allocate, and take some milliseconds.
  void AfterTick() {
    if (live_ == nullptr || ++ticks_ % kPeriod_ticks != 0) return;
    for (std::uint32_t n = 0; n < live_->sculpt_session_count(); ++n) live_->sculpt_session_at(n).Poll();
  }

 private:
  void SetReader(bool present) {
    for (std::uint32_t n = 0; live_ != nullptr && n < live_->sculpt_session_count(); ++n) {
      live_->sculpt_session_at(n).SetReader(present);
    }
  }

  LiveParts* live_;
  int ticks_ = 0;
};

// Every sculpted object as it is now, open strokes included, with the materials it uses (without their images), in the
// base frame. Called by the thread that edits. Empty without sculpt sessions.
SceneInput SculptedScene(const Scene& scene, const LiveParts& live);

}  // namespace omni::haptics::sculpt
