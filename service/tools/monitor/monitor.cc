// omni monitor: the live page of a running omnid.
#include "service/tools/monitor/monitor.h"

#include <cstdio>
#include <limits>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/config/files/device_file.h"
#include "service/monitor/monitor.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/service_link.h"
#include "service/tools/common/terminal.h"
#include "service/tools/setup/setup.h"

namespace omni::tools {
namespace {

constexpr const char* kMonitorCommand = "omni monitor";

struct MonitorArguments {
  std::string socket, csv;
  int port = 0;
  bool control = false, open = true;
  double seconds = std::numeric_limits<double>::infinity();
};

int WriteCsv(const MonitorArguments& arguments) {
  const EndSignals signals;
  const auto connection = ConnectToService(arguments.socket);
  if (!connection.ok()) {
    Fail(kMonitorCommand, connection.error());
    return kExitNoService;
  }
  const base::Result<TelemetryCount> count = WriteTelemetry(**connection, arguments.csv, arguments.seconds);
  if (!count.ok()) return Fail(kMonitorCommand, count.error());
  std::printf("%s: %llu ticks, %llu lost\n", arguments.csv.c_str(), static_cast<unsigned long long>(count->rows),
              static_cast<unsigned long long>(count->lost));
  return kExitOk;
}

int MonitorPage(const MonitorArguments& arguments) {
  if (!arguments.csv.empty()) return WriteCsv(arguments);
  const EndSignals signals;
  const base::Result<std::string> folder = FindPage();
  if (!folder.ok()) return Fail(kMonitorCommand, folder.error());
  const auto monitor = monitor::Monitor::Start({.port = static_cast<std::uint16_t>(arguments.port),
                                                .page_folder = *folder,
                                                .socket_path = arguments.socket,
                                                .control = arguments.control,
                                                .hello = {.version = OMNI_VERSION,
                                                          .control = arguments.control,
                                                          .max_file_bytes = 0,
                                                          .device = config::DefaultDevice()},
                                                .setup_steps = SetupStepRows},
                                               nullptr);
  if (!monitor.ok()) return Fail(kMonitorCommand, monitor.error());
  std::printf("open  %s\n", (*monitor)->address().c_str());
  std::printf(arguments.control ? "pages may change and stop; Ctrl-C ends\n"
                                : "pages only look and stop; --control lets them change; Ctrl-C ends\n");
  std::fflush(stdout);
  if (arguments.open) OpenBrowser((*monitor)->browser_address());
  const std::int64_t start_ns = base::MonotonicNow_ns();
  while (!EndSignals::asked() && static_cast<double>(base::MonotonicNow_ns() - start_ns) * 1e-9 < arguments.seconds) {
    (*monitor)->Step();
  }
  return kExitOk;
}

}  // namespace

void AddMonitor(Command& app) {
  auto arguments = std::make_shared<MonitorArguments>();
  Command monitor = app.AddCommand("monitor", "show everything of a running omnid on a live page in the browser");
  const console::Option csv =
      monitor.Add("--csv", arguments->csv, "no page: write every tick to this new file, one row each");
  monitor.Add("--port", arguments->port, "of 127.0.0.1 (default: any that is free)").Range(1, 65535).Excludes(csv);
  monitor.Add("--control", arguments->control, "let pages undo, save and release the emergency stop").Excludes(csv);
  monitor.Add("!--no-open", arguments->open, "do not open a browser");
  monitor.Add("--seconds", arguments->seconds, "end after this many seconds (default: at Ctrl-C)").Positive();
  AddSocket(monitor, arguments->socket);
  monitor.SetAction(arguments, MonitorPage);
}

}  // namespace omni::tools
