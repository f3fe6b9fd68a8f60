#include "tests/bench/paper/paper.h"

#include <iostream>
#include <memory>

#include "service/config/files/device_file.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "tests/bench/harness/commands.h"

namespace omni::bench {
namespace {

struct PaperArguments {
  PaperOptions options;
  std::string json;
  std::string only;
};

struct SectionEntry {
  const char* name;
  PaperSection (*make)(const base::DeviceGeometry&, const PaperOptions&);
};
constexpr SectionEntry kSections[] = {
    {"tracking", PaperTracking},
    {"forces", [](const base::DeviceGeometry& device, const PaperOptions&) { return PaperForces(device); }},
    {"decay", [](const base::DeviceGeometry& device, const PaperOptions&) { return PaperDecay(device); }},
    {"heat", [](const base::DeviceGeometry& device, const PaperOptions&) { return PaperHeat(device); }},
    {"magnets", [](const base::DeviceGeometry& device, const PaperOptions&) { return PaperMagnets(device); }},
};

int RunPaper(const PaperArguments& arguments) {
  std::cout << "paper: Langerak et al., Omni, UIST 2020; twin and ours: simulation\n";
  BenchRows all;
  for (const SectionEntry& entry : kSections) {
    if (!arguments.only.empty() && arguments.only != entry.name) continue;
    const PaperSection section = entry.make(config::DefaultDevice(), arguments.options);
    BenchRows own = section.rows;
    const auto drawn = tools::TakeSideTables(own);  // too long to print
    std::cout << "\n" << section.title << "\n" << tools::RowTable(own);
    for (const std::string& note : section.notes) std::cout << "  " << note << "\n";
    std::cout << std::flush;
    for (const nlohmann::ordered_json& row : section.rows) {
      nlohmann::ordered_json flat;
      if (!row.contains("table")) flat["section"] = entry.name;
      flat.update(row);
      all.push_back(flat);
    }
  }
  return KeepRows("paper", all, arguments.json);
}

}  // namespace

void AddPaper(Command& app) {
  Command paper = app.AddCommand("paper", "the published figures compared with the twin's and ours");
  auto arguments = std::make_shared<PaperArguments>();
  std::vector<std::string> names;
  for (const SectionEntry& entry : kSections) names.emplace_back(entry.name);
  paper.Add("section", arguments->only, "only this section").OneOf(names);
  paper.Add("--json", arguments->json,
            "write {name, commit, machine, rows, tables} here as well; scripts/plot draws it");
  paper.Add("--seed", arguments->options.seed, "of the first rig").ShowDefault();
  paper.Add("--rigs", arguments->options.rigs, "simulated devices, pooled").Range(1, 1000).ShowDefault();
  paper.Add("--poses", arguments->options.poses, "per rig and condition").Range(1, 100000).ShowDefault();
  paper.SetAction(arguments, RunPaper);
}

}  // namespace omni::bench
