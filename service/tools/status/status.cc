// omni status: the current state of the service.
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "service/tools/common/commands.h"
#include "service/tools/common/json_text.h"
#include "service/tools/common/service_link.h"
#include "service/tools/common/text_output.h"
#include "service/tools/status/status_text.h"

namespace omni::tools {
namespace {

struct StatusArguments {
  std::string socket;
  bool as_json = false;
};

int Status(const StatusArguments& arguments) {
  const base::Result<nlohmann::json> status = FetchStatus(arguments.socket);
  if (!status.ok()) return FailWith(arguments.as_json, "omni status", status.error(), kExitNoService);
  if (arguments.as_json) {
    PrintJson(*status);
  } else {
    Print(StatusText(*status));
  }
  return kExitOk;
}

}  // namespace

void AddStatus(Command& app) {
  auto arguments = std::make_shared<StatusArguments>();
  Command status = app.AddCommand("status", "show what omnid does: device, tick, pen, force, clients, problems");
  status.Add("--json", arguments->as_json, "as JSON");
  AddSocket(status, arguments->socket);
  status.Run(arguments, Status);
}

}  // namespace omni::tools
