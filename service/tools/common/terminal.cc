#include "service/tools/common/terminal.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <string_view>

#include "service/console/wrap.h"

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

}  // namespace omni::tools
