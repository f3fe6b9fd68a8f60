// What a person sees of something that takes longer than two seconds: how far it is, and how long it still takes.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace omni::tools {

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
