#include "service/tools/common/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "service/base/clock.h"
#include "service/tools/common/text_output.h"

namespace omni::tools {
namespace {

constexpr double kEarly_s = 1, kEarly = 0.05;  // before both, any estimate would be a guess
constexpr int kTerminalBar = 30;
constexpr double kUpdate_s = 0.1;

double Now_s() { return 1e-9 * static_cast<double>(base::MonotonicNow_ns()); }

}  // namespace

std::string ProgressBar(double progress, int width) {
  const double share = std::clamp(progress, 0.0, 1.0);
  const auto full = static_cast<std::size_t>(share * width);
  return "[" + std::string(full, '#') + std::string(static_cast<std::size_t>(width) - full, '.') +
         Printed("] %3.0f %%", 100 * share);
}

std::string TimeLeft::Text(double progress, double t_s) {
  if (!begin_s_ || progress < progress_) begin_s_ = t_s;
  progress_ = progress;
  const double elapsed_s = t_s - *begin_s_;
  if (elapsed_s < kEarly_s || progress < kEarly || progress >= 1) return {};
  const double left_s = elapsed_s * (1 - progress) / progress;
  const double step_s = left_s < 10 ? 1 : left_s < 60 ? 5 : 30;
  return Printed(", about %.0f s left", std::max(1.0, std::ceil(left_s / step_s)) * step_s);
}

std::string TimeLeft::Text(double progress) { return Text(progress, Now_s()); }

std::function<bool(double done)> ProgressOnTerminal(const std::string& what) {
  if (::isatty(STDERR_FILENO) != 1) return {};
  struct Line {
    std::string what;
    TimeLeft left;
    bool shown = false;
    double next_s = 0;
    ~Line() {
      if (shown) std::fprintf(stderr, "\r\033[K");
    }
  };
  const auto line = std::make_shared<Line>(Line{.what = what, .left = {}});
  line->left.Text(0);
  return [line](double done) {
    const double now_s = Now_s();
    if (now_s < line->next_s) return true;
    std::fprintf(stderr, "\r\033[K%s %s%s", line->what.c_str(), ProgressBar(done, kTerminalBar).c_str(),
                 line->left.Text(done, now_s).c_str());
    line->shown = true;
    line->next_s = now_s + kUpdate_s;
    return true;
  };
}

}  // namespace omni::tools
