// omni stop: the emergency stop of a running omnid.
#include <ctime>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/base/files/json_document.h"
#include "service/protocol/text.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"

namespace omni::tools {
namespace {

struct StopArguments {
  std::string socket;
  bool release = false;
};

constexpr int kPolls = 150;  // of the status, every 20 ms, while the disk keeps or forgets the stop
constexpr timespec kPollPause{0, 20'000'000};

// The service has no answer of its own to this message: its status shows what became of it. An error: no status.
base::Result<nlohmann::json> WaitForLatch(client::Connection& connection) {
  base::Result<nlohmann::json> status = RequestStatus(connection);
  for (int i = 0; i < kPolls && status.ok() && base::StringAt(*status, "/stop/latch") == "pending"; ++i) {
    nanosleep(&kPollPause, nullptr);
    status = RequestStatus(connection);
  }
  return status;
}

std::string Outcome(const nlohmann::json& status, bool stopped) {
  const std::string latch = base::StringAt(status, "/stop/latch");
  const std::string problem =
      latch == "pending" ? "the disk does not respond" : base::StringAt(status, "/stop/problem");
  if (!stopped) {
    return "released: applications may push again" +
           (problem.empty() ? "" : "; but the next omnid starts stopped: " + problem);
  }
  const std::string since =
      "stopped at " + base::StringAt(status, "/stop/at") + " by " + base::StringAt(status, "/stop/by");
  if (problem.empty()) return since + ": no force until `omni stop --release`, also after a restart";
  return since + ": no force until `omni stop --release`, or until omnid ends: " + problem;
}

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
  const base::Result<nlohmann::json> status = WaitForLatch(**connection);
  if (!status.ok()) return Fail(kCommand, status.error());
  const bool stopped = !base::StringAt(*status, "/stopped").empty();
  if (stopped == arguments.release) return Fail(kCommand, "omnid has not done it; end it (Ctrl-C): coils go to zero");
  Print(protocol::Printable(Outcome(*status, stopped)) + "\n");
  return kExitOk;
}

}  // namespace

void AddStop(Command& app) {
  auto arguments = std::make_shared<StopArguments>();
  Command stop = app.AddCommand("stop", "emergency stop: no force until it is released");
  stop.Add("--release", arguments->release, "end it: applications may push again");
  AddSocket(stop, arguments->socket);
  stop.SetAction(arguments, Stop);
}

}  // namespace omni::tools
