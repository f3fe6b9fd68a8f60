// One sculpted object: the editor with its thread's end of the ring, and what the tick needs of it.
#pragma once

#include <memory>
#include <utility>

#include "service/haptics/sculpt/sculpt_tool.h"
#include "service/haptics/sculpt/stroke_server.h"

namespace omni::haptics::sculpt {

class Workshop {
 public:
  // `editor` not null. The first generation is published here, so that the tick always finds one.
  Workshop(std::unique_ptr<SculptEditor> editor, const SculptFeel& feel, const Brush& brush)
      : feel_(feel), brush_(brush), editor_(std::move(editor)), server_(*editor_, ring_) {
    editor_->Publish();
  }
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;

  // The tick's side.
  const SculptFeel& feel() const noexcept { return feel_; }
  const Brush& brush() const noexcept { return brush_; }
  const SculptTable* Acquire() noexcept { return editor_->publisher().Acquire(); }
  StrokeRing& ring() noexcept { return ring_; }

  // The side of who draws, one thread: SculptPublisher::Pin.
  const SculptTable* Pin() noexcept { return editor_->publisher().Pin(); }
  void Unpin() noexcept { editor_->publisher().Unpin(); }

  // The editor's side, one thread.
  SculptEditor& editor() noexcept { return *editor_; }
  ServeReport Poll() { return server_.Poll(); }
  // The tick begins or has ceased to look at this (SculptPublisher::SetReader).
  // A stroke that is open when it ceases is ended: its tool is gone.
  void SetReader(bool present) {
    if (!present) server_.Close();
    editor_->publisher().SetReader(present);
  }

 private:
  const SculptFeel feel_;
  const Brush brush_;
  StrokeRing ring_;
  std::unique_ptr<SculptEditor> editor_;
  StrokeServer server_;
};

}  // namespace omni::haptics::sculpt
