#include "service/tools/common/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>

#include "service/base/clock.h"
#include "service/console/wrap.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
constexpr std::string_view kEnter = "\033[?1049h\033[?25l";
constexpr std::string_view kLeave = "\033[?25h\033[?1049l";
constexpr std::string_view kHome = "\033[H";
constexpr std::string_view kClearToEndOfLine = "\033[K\r\n";
constexpr std::string_view kClearBelow = "\033[J";

std::atomic<bool> end_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // a signal handler may store to it

struct sigaction previous_actions[std::size(kSignals)];

void OnSignal(int) { end_asked.store(true, std::memory_order_relaxed); }

bool WriteAll(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

bool CanDraw() {
  const char* term = std::getenv("TERM");
  return ::isatty(STDOUT_FILENO) == 1 && term != nullptr && std::string_view(term) != "dumb";
}

EndSignals::EndSignals() {
  end_asked.store(false, std::memory_order_relaxed);
  struct sigaction action {};
  action.sa_handler = OnSignal;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < std::size(kSignals); ++i) ::sigaction(kSignals[i], &action, &previous_actions[i]);
}

EndSignals::~EndSignals() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i) ::sigaction(kSignals[i], &previous_actions[i], nullptr);
}

bool EndSignals::asked() noexcept { return end_asked.load(std::memory_order_relaxed); }

AlternateScreen::AlternateScreen() { WriteAll(kEnter); }
AlternateScreen::~AlternateScreen() { WriteAll(kLeave); }

bool AlternateScreen::Show(const std::string& lines) {
  const console::TerminalSize size = console::SizeOfTerminal();
  std::string text(kHome);
  int rows = 1;
  for (const char c : console::Wrap(lines, size.columns)) {
    if (c == '\n' && ++rows > size.rows) break;  // one more line would scroll the first one away
    if (c == '\n') {
      text += kClearToEndOfLine;
    } else {
      text += c;
    }
  }
  text += kClearBelow;
  return WriteAll(text);
}

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
         Format("] %3.0f %%", 100 * share);
}

std::string TimeLeft::Text(double progress, double t_s) {
  if (!begin_s_ || progress < progress_) begin_s_ = t_s;
  progress_ = progress;
  const double elapsed_s = t_s - *begin_s_;
  if (elapsed_s < kEarly_s || progress < kEarly || progress >= 1) return {};
  const double left_s = elapsed_s * (1 - progress) / progress;
  const double step_s = left_s < 10 ? 1 : left_s < 60 ? 5 : 30;
  return Format(", about %.0f s left", std::max(1.0, std::ceil(left_s / step_s)) * step_s);
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
