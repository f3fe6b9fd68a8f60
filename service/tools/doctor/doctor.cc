// omni doctor: what keeps OpenXR applications from using the pen, and how to fix it.
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/config/paths.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/commands.h"
#include "service/tools/common/json_text.h"
#include "service/tools/common/text_output.h"
#include "service/tools/doctor/doctor_text.h"

namespace omni::tools {
namespace {

struct DoctorArguments {
  std::string socket;
  bool as_json = false, fix = false;
};

// Our own program is this one, whatever $PATH has.
int RunCommand(const std::string& command) {
  const bool ours = command.starts_with("omni ");
  return std::system((ours ? "'" + config::ProgramFolder() + "/omni' " + command.substr(5) : command).c_str());
}

// Asks for each finding whose fix is a command. True: at least one of them worked.
bool ApplyFixes(const std::vector<Diagnosed>& findings) {
  bool applied = false, any = false;
  for (const Diagnosed& row : findings) {
    if (row.finding.apply.empty()) continue;
    any = true;
    Print("\n" + row.name + ": " + row.finding.what + "\nrun `" + row.finding.apply + "`? [y/N] ");
    std::cout << std::flush;
    std::string answer;
    if (!std::getline(std::cin, answer) || (answer != "y" && answer != "yes")) continue;
    const bool worked = RunCommand(row.finding.apply) == 0;
    Print(worked ? "done\n" : "that did not work, see above; nothing else was changed\n");
    applied |= worked;
  }
  if (!any) Print("\nnothing here can be fixed by a command alone\n");
  return applied;
}

int Doctor(const DoctorArguments& arguments) {
  Surroundings surroundings = SurroundingsOfThisProcess(arguments.socket);
  std::vector<Diagnosed> findings = Diagnose(surroundings);
  const nlohmann::json& status = surroundings.service.status;
  if (arguments.as_json) {
    PrintJson(DoctorJson(findings, status));
  } else {
    Print(DoctorText(findings, status));
    if (arguments.fix && ApplyFixes(findings)) {
      surroundings = SurroundingsOfThisProcess(arguments.socket);
      findings = Diagnose(surroundings);
      Print("\n" + DoctorText(findings, surroundings.service.status));
    }
  }
  if (!AnyFailed(findings)) return kExitOk;
  return Fail("omni doctor", "some checks failed; apply the fixes above from top to bottom");
}

}  // namespace

void AddDoctor(Command& app) {
  auto arguments = std::make_shared<DoctorArguments>();
  Command doctor = app.AddCommand("doctor", "check what keeps applications from using the pen, and how to fix it");
  const console::Option json = doctor.Add("--json", arguments->as_json, "as JSON");
  doctor.Add("--fix", arguments->fix, "then apply what can be applied, asking before each").Excludes(json);
  AddSocket(doctor, arguments->socket);
  doctor.Run(arguments, Doctor);
}

}  // namespace omni::tools
