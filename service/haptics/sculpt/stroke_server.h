// The editor's end of the ring: reads what the tick sent, edits, publishes. Called by the editor's thread as often as
// it likes; every 1 to 5 ms feels immediate.
#pragma once

#include "service/haptics/sculpt/sculpt_editor.h"

namespace omni::haptics::sculpt {

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

}  // namespace omni::haptics::sculpt
