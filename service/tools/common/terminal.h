// The terminal while `omni watch` owns it: alternate screen, no cursor, restored on every exit.
#pragma once

#include <string>

namespace omni::tools {

// True: stdout is a terminal that can be drawn on.
bool CanDraw();

// SIGINT, SIGTERM and SIGHUP end the wait instead of the process. Only one at a time.
class EndSignals {
 public:
  EndSignals();
  ~EndSignals();
  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;
  static bool asked() noexcept;
};

class AlternateScreen {
 public:
  AlternateScreen();
  ~AlternateScreen();
  AlternateScreen(const AlternateScreen&) = delete;
  AlternateScreen& operator=(const AlternateScreen&) = delete;
  // Replaces what is shown; false: the terminal is gone.
  bool Show(const std::string& lines);
};

}  // namespace omni::tools
