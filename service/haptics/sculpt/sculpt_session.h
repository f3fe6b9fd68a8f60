// One sculpted object: the editor with its thread's end of the ring, and what the tick needs of it.
#pragma once

#include <atomic>
#include <memory>
#include <utility>

#include "service/haptics/sculpt/sculpt_editor.h"
#include "service/haptics/sculpt/sculpt_tool.h"

namespace omni::haptics::sculpt {

// The editor's end of the ring: reads what the tick sent, edits, publishes. Called by the editor's thread as often as
// it likes; every 1 to 5 ms feels immediate.
struct ServeReport {
  std::uint32_t messages = 0;
  std::uint32_t begun = 0, ended = 0;
  PublishReport publish;
  std::string problem;  // why a stroke was refused; its moves are ignored
};

class StrokeServer {
 public:
  StrokeServer(SculptEditor& editor, StrokeRing& ring) : editor_(editor), ring_(ring) {}

  // Everything in the ring, moves of one stroke joined to the newest, then one publish.
  ServeReport Poll();
  // Ends an open stroke; what it did stays.
  void Close();

 private:
  void Begin(const StrokeMessage& message, ServeReport& report);

  SculptEditor& editor_;
  StrokeRing& ring_;
  std::uint32_t open_ = 0;  // stroke the editor is in; 0: none
};

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
  std::uint32_t releases() const noexcept { return releases_.load(std::memory_order_relaxed); }

  // The drawing side, one thread: SculptPublisher::Pin.
  const SculptTable* Pin() noexcept { return editor_->publisher().Pin(); }
  void Unpin() noexcept { editor_->publisher().Unpin(); }

  // The editor's side, one thread.
  SculptEditor& editor() noexcept { return *editor_; }
  ServeReport Poll() { return server_.Poll(); }
  // The tick lets go of what it holds.
  void Release() noexcept { releases_.fetch_add(1, std::memory_order_relaxed); }
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
  std::atomic<std::uint32_t> releases_ = 0;
  std::unique_ptr<SculptEditor> editor_;
  StrokeServer server_;
};

}  // namespace omni::haptics::sculpt
