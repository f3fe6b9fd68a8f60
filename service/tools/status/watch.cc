// omni watch: the pen, live. Reads the state memory; requests the status once a second.
#include <chrono>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/console/wrap.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "service/tools/common/terminal.h"
#include "service/tools/status/status.h"

namespace omni::tools {
namespace {

constexpr auto kFramePeriod = std::chrono::milliseconds(50);
constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kFirstPause_ns = 300'000'000;  // a rate needs two answers: the second soon

struct WatchArguments {
  std::string socket;
  double seconds = std::numeric_limits<double>::infinity();
};

// Keeps the connection and fills one WatchFrame after another.
class Watcher {
 public:
  explicit Watcher(const std::string& socket)
      : connection_({.role = protocol::ClientRole::kMonitor,
                     .application = "omni watch",
                     .engine = "",
                     .socket_path = socket}) {
    frame_.tick_rate_Hz = std::nan("");
  }

  const WatchFrame& Next(std::int64_t now_ns) {
    connection_.Poll(now_ns);
    connection_.SignalAlive();
    frame_.now_ns = now_ns;
    frame_.connected = connection_.connected();
    frame_.problem = connection_.last_error();
    const auto state = connection_.state();
    frame_.has_sample = state != nullptr && state->ReadNewest(frame_.sample);
    if (!frame_.has_sample) frame_.sample = {};
    if (state == nullptr || !state->ReadInputs(frame_.inputs)) frame_.inputs = {};
    if (frame_.connected) {
      ReadStatus(now_ns);
    } else {
      Forget();
    }
    return frame_;
  }

  bool was_connected() const { return was_connected_; }

 private:
  void ReadStatus(std::int64_t now_ns) {
    was_connected_ = true;
    if (now_ns >= next_request_ns_ && connection_.Send(protocol::StatusRequest{})) {
      next_request_ns_ = now_ns + (std::isnan(ticks_) ? kFirstPause_ns : kSecond_ns);
    }
    const std::string text = connection_.PopStatus();
    if (text.empty()) return;
    frame_.status = ParseJsonOrNull(text);
    const double ticks = NumberAt(frame_.status, "/tick/count");
    frame_.tick_rate_Hz = (ticks - ticks_) / (static_cast<double>(now_ns - ticks_at_ns_) * 1e-9);
    ticks_ = ticks;
    ticks_at_ns_ = now_ns;
  }

  void Forget() {
    frame_.status = nullptr;
    frame_.tick_rate_Hz = ticks_ = std::nan("");
    next_request_ns_ = 0;
  }

  client::Connection connection_;
  WatchFrame frame_;
  std::int64_t next_request_ns_ = 0;
  std::int64_t ticks_at_ns_ = 0;
  double ticks_ = std::nan("");
  bool was_connected_ = false;
};

// Runs `show` at 20 Hz until it returns false, the time is over or a signal arrives.
template <class Show>
void Run(Watcher& watcher, double seconds, const Show& show) {
  const std::int64_t start_ns = base::MonotonicNow_ns();
  for (;;) {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    const bool over = static_cast<double>(now_ns - start_ns) * 1e-9 >= seconds;
    if (over || EndSignals::asked() || !show(watcher.Next(now_ns), now_ns)) return;
    std::this_thread::sleep_for(kFramePeriod);
  }
}

void DrawUntilEnd(Watcher& watcher, double seconds) {
  AlternateScreen screen;
  Run(watcher, seconds, [&screen](const WatchFrame& frame, std::int64_t) {
    return screen.Show(WatchScreen(frame, console::SizeOfTerminal().columns));
  });
}

void PrintUntilEnd(Watcher& watcher, double seconds) {
  std::int64_t next_ns = 0;
  Run(watcher, seconds, [&next_ns](const WatchFrame& frame, std::int64_t now_ns) {
    if (now_ns < next_ns || (!frame.connected && frame.problem.empty())) return true;  // still greeting
    next_ns = now_ns + kSecond_ns;
    std::cout << WatchLine(frame) << std::flush;
    return std::cout.good();
  });
}

int Watch(const WatchArguments& arguments) {
  const EndSignals signals;
  Watcher watcher(arguments.socket);
  if (CanDraw()) {
    DrawUntilEnd(watcher, arguments.seconds);
  } else {
    PrintUntilEnd(watcher, arguments.seconds);
  }
  if (watcher.was_connected()) return kExitOk;
  const std::string path = arguments.socket.empty() ? client::DefaultSocketPath() : arguments.socket;
  Fail("omni watch", "omnid never answered at " + path + "; start it with `omnid --device twin`");
  return kExitNoService;
}

}  // namespace

void AddWatch(Command& app) {
  auto arguments = std::make_shared<WatchArguments>();
  Command watch = app.AddCommand("watch", "show the pen live: pose, gap, force, contact, inputs");
  watch.Add("--seconds", arguments->seconds, "stop after this many seconds (default: at Ctrl-C)").Positive();
  AddSocket(watch, arguments->socket);
  watch.SetAction(arguments, Watch);
}

}  // namespace omni::tools
