// omni doctor: what keeps OpenXR applications from using the pen, and how to fix it.
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "service/tools/common/commands.h"
#include "service/tools/common/text_output.h"
#include "service/tools/doctor/doctor_text.h"

namespace omni::tools {
namespace {

struct DoctorArguments {
  std::string socket;
  bool as_json = false;
};

int Doctor(const DoctorArguments& arguments) {
  const Surroundings surroundings = SurroundingsOfThisProcess(arguments.socket);
  const std::vector<Diagnosed> findings = Diagnose(surroundings);
  const nlohmann::json& status = surroundings.service.status;
  if (arguments.as_json) {
    std::cout << DoctorJson(findings, status).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
  } else {
    Print(DoctorText(findings, status));
  }
  if (!AnyFailed(findings)) return kExitOk;
  return Fail("omni doctor", "some checks failed; apply the fixes above from top to bottom");
}

}  // namespace

void AddDoctor(Command& app) {
  auto arguments = std::make_shared<DoctorArguments>();
  Command doctor = app.AddCommand("doctor", "check what keeps applications from using the pen, and how to fix it");
  doctor.Add("--json", arguments->as_json, "as JSON");
  AddSocket(doctor, arguments->socket);
  doctor.Run(arguments, Doctor);
}

}  // namespace omni::tools
