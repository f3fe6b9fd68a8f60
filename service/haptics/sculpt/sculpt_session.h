// One sculpted object: the editor with its thread's end of the ring, and what the tick needs of it.
#pragma once

#include <memory>
#include <utility>

#include "service/haptics/sculpt/sculpt_tool.h"
#include "service/haptics/sculpt/stroke_server.h"

namespace omni::haptics::sculpt {

class SculptSession {
 public:
  // `editor` not null. The first generation is published here, so that the tick always finds one.
  SculptSession(std::unique_ptr<SculptEditor> editor, const SculptParameters& parameters, const Brush& brush)
      : parameters_(parameters), brush_(brush), editor_(std::move(editor)), server_(*editor_, ring_) {
    editor_->Publish();
  }
  SculptSession(const SculptSession&) = delete;
  SculptSession& operator=(const SculptSession&) = delete;

  // The tick's side.
  const SculptParameters& parameters() const noexcept { return parameters_; }
  const Brush& brush() const noexcept { return brush_; }
  const SculptTable* Acquire() noexcept { return editor_->publisher().Acquire(); }
  StrokeRing& ring() noexcept { return ring_; }

  // The drawing side, one thread: SculptPublisher::Pin.
  const SculptTable* Pin() noexcept { return editor_->publisher().Pin(); }
  void Unpin() noexcept { editor_->publisher().Unpin(); }

  // The editor's side, one thread.
  SculptEditor& editor() noexcept { return *editor_; }
  ServeReport Poll() { return server_.Poll(); }
  // The tick starts or has stopped reading this (SculptPublisher::SetReader). A stroke that is open when it stops is
  // ended: its tool is gone.
  void SetReader(bool present) {
    if (!present) server_.Close();
    editor_->publisher().SetReader(present);
  }

 private:
  const SculptParameters parameters_;
  const Brush brush_;
  StrokeRing ring_;
  std::unique_ptr<SculptEditor> editor_;
  StrokeServer server_;
};

}  // namespace omni::haptics::sculpt
