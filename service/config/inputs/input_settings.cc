#include "service/config/inputs/input_settings.h"

#include <filesystem>
#include <utility>

#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

constexpr std::size_t kMaxDevicePathBytes = 1024;
constexpr std::size_t kMaxDeviceNameBytes = 255;

KeyDeviceRule ReadDevice(TableReader& reader, FileProblem& problem) {
  KeyDeviceRule rule;
  const bool by_path = reader.table().contains("path");
  if (by_path == reader.table().contains("name")) {
    problem.Report(&reader.table(), reader.NameOf("path") + " and name: exactly one of the two is needed; " +
                                        "/proc/bus/input/devices lists the names");
  }
  if (by_path) {
    rule.path = reader.Text("path", kMaxDevicePathBytes);
    if (!rule.path.empty() && rule.path.front() != '/') {
      problem.Report(reader.table().get("path"), reader.NameOf("path") + " = \"" + rule.path +
                                                     "\" is not absolute; write it as /dev/input/by-id/...");
    }
  } else {
    rule.name_glob = reader.Text("name", kMaxDeviceNameBytes);
  }
  rule.grab = reader.Boolean("grab", false);
  reader.ReportUnknownKeys();
  return rule;
}

std::string TooManyKeys(const std::string& file) {
  return file + ": [inputs]: more than " + std::to_string(base::kMaxKeys) +
         " different keys in all files together; its mapping is not used";
}

}  // namespace

base::Result<InputSettings> ParseInputSettings(const std::string& text, const std::string& file) {
  const base::Result<toml::table> parsed = ParseToml(text, file);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(file);
  TableReader root(problem, *parsed, "");
  InputSettings settings;
  settings.hand = root.Choice("hand", kHands, "auto");
  if (parsed->contains("devices")) {
    std::size_t i = 0;
    for (const toml::table* table : root.Tables("devices", 1, kMaxKeyDevices)) {
      TableReader reader(problem, *table, "devices[" + std::to_string(i++) + "]");
      settings.devices.push_back(ReadDevice(reader, problem));
    }
  }
  if (parsed->contains("inputs")) {
    if (const toml::table* table = root.Table("inputs")) {
      TableReader reader(problem, *table, "inputs");
      settings.inputs = ReadInputs(reader, problem);
    }
  }
  root.AllowKeys({"devices", "inputs"});
  root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  return settings;
}

InputPlan PlanInputs(const std::string& file, AppTable& apps) {
  InputPlan plan;
  std::error_code error;
  if (!file.empty() && std::filesystem::exists(file, error)) {
    const base::Result<std::string> text = ReadTextFile(file);
    base::Result<InputSettings> settings = text.ok() ? ParseInputSettings(*text, file) : base::Error{text.error()};
    if (settings.ok()) {
      plan.file = file;
      plan.hand = settings->hand;
      plan.devices = std::move(settings->devices);
      if (settings->inputs) plan.fallback = std::move(*settings->inputs);
    } else {
      apps.problems.push_back(settings.error());
    }
  }
  ShareKeys(plan.slots, plan.fallback);  // of one file: they fit
  for (AppEntry& app : apps.entries) {
    if (!app.inputs || ShareKeys(plan.slots, *app.inputs)) continue;
    apps.problems.push_back(TooManyKeys(app.file));
    app.inputs.reset();
  }
  return plan;
}

}  // namespace omni::config
