// What a command draws on a terminal.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace omni::tools {

// The terminal while `omni watch` owns it: alternate screen, no cursor, restored on every exit.

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

// What a person sees of something that takes longer than two seconds: how far it is, and how long it still takes.

// "[####......]  40 %"
std::string ProgressBar(double progress, int width);

// From how fast it has gone so far.
class TimeLeft {
 public:
  // `progress`: 0 to 1; if it goes back, something else has begun. t_s: any clock. ", about 12 s left"; empty while it
  // is too early to say, and once it is done.
  std::string Text(double progress, double t_s);
  std::string Text(double progress);  // now

 private:
  std::optional<double> begin_s_;
  double progress_ = 0;
};

// For `what`, on stderr if that is a terminal: one line that is updated and goes away at the end. Always returns true.
std::function<bool(double done)> ProgressOnTerminal(const std::string& what);

}  // namespace omni::tools
