#include "service/tools/doctor/doctor_text.h"

#include <algorithm>
#include <array>

#include "service/tools/common/json_text.h"

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
  for (const DiagnosisEntry& entry : Diagnoses()) findings.push_back({entry.name, entry.look(surroundings)});
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

}  // namespace omni::tools
