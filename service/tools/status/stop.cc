// omni stop: the emergency stop of a running omnid.
#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/base/files/json_values.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/commands.h"
#include "service/tools/common/service_link.h"

namespace omni::tools {
namespace {

struct StopArguments {
  std::string socket;
  bool release = false;
};

// The service has no answer of its own to this message: its status shows whether it arrived.
int Stop(const StopArguments& arguments) {
  constexpr const char* kCommand = "omni stop";
  auto connection = ConnectToService(arguments.socket, protocol::ClientRole::kTool);
  if (!connection.ok()) {
    Fail(kCommand, connection.error());
    return kExitNoService;
  }
  protocol::EmergencyStop stop;
  stop.on = arguments.release ? 0 : 1;
  if (!(*connection)->Send(stop)) return Fail(kCommand, "not sent: omnid does not read its socket; end it (Ctrl-C)");
  const base::Result<nlohmann::json> status = RequestStatus(**connection);
  if (!status.ok()) return Fail(kCommand, status.error());
  const bool stopped = !base::StringAt(*status, "/stopped").empty();
  if (stopped == arguments.release) return Fail(kCommand, "omnid has not done it; end it (Ctrl-C): coils go to zero");
  std::puts(stopped ? "stopped: no force until `omni stop --release`" : "released: applications may push again");
  return kExitOk;
}

}  // namespace

void AddStop(Command& app) {
  auto arguments = std::make_shared<StopArguments>();
  Command stop = app.AddCommand("stop", "emergency stop: no force until it is released");
  stop.Add("--release", arguments->release, "end it: applications may push again");
  AddSocket(stop, arguments->socket);
  stop.Run(arguments, Stop);
}

}  // namespace omni::tools
