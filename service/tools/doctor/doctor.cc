#include "service/tools/doctor/diagnosis.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/config/paths.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

constexpr std::array<const char*, 3> kWords = {"ok", "warn", "fail"};

const char* WordFor(Verdict verdict) { return kWords.at(static_cast<std::size_t>(verdict)); }

std::string Padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

}  // namespace

std::vector<Diagnosed> Diagnose(const Surroundings& surroundings) {
  std::vector<Diagnosed> findings;
  for (const DiagnosisEntry& entry : DiagnosisTable()) findings.push_back({entry.name, entry.look(surroundings)});
  return findings;
}

std::string DoctorText(const std::vector<Diagnosed>& findings, const nlohmann::json& status) {
  std::string text = SimulationLine(status);
  for (const Diagnosed& row : findings) {
    text += Padded(WordFor(row.finding.verdict), 6) + Padded(row.name, 16) + row.finding.what + "\n";
    if (!row.finding.fix.empty()) text += Padded("", 22) + "fix: " + row.finding.fix + "\n";
  }
  return text;
}

nlohmann::json DoctorJson(const std::vector<Diagnosed>& findings, const nlohmann::json& status) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Diagnosed& row : findings) {
    rows.push_back({{"name", row.name},
                    {"verdict", WordFor(row.finding.verdict)},
                    {"what", row.finding.what},
                    {"fix", row.finding.fix},
                    {"apply", row.finding.apply}});
  }
  nlohmann::json document = {{"ok", !AnyFailed(findings)}, {"diagnoses", rows}};
  if (status.contains("SIMULATION")) document["SIMULATION"] = status["SIMULATION"];
  return document;
}

bool AnyFailed(const std::vector<Diagnosed>& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Diagnosed& row) { return row.finding.verdict == Verdict::kFail; });
}

// omni doctor: what keeps OpenXR applications from using the pen, and how to fix it.

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
  const console::Option as_json = doctor.Add("--json", arguments->as_json, "as JSON");
  doctor.Add("--fix", arguments->fix, "then apply what can be applied, asking before each").Excludes(as_json);
  AddSocket(doctor, arguments->socket);
  doctor.SetAction(arguments, Doctor);
}

}  // namespace omni::tools
