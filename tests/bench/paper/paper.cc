#include "tests/bench/paper/paper.h"

#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "service/config/device_file.h"
#include "service/tools/command_line.h"
#include "service/tools/text_output.h"
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
  if (arguments.json.empty()) return tools::kExitOk;
  const std::string problem = tools::WriteText(arguments.json, tools::RowDocument("paper", all).dump(2) + "\n");
  return problem.empty() ? tools::kExitOk : tools::Fail("omni-bench paper", problem);
}

}  // namespace

void AddPaper(CLI::App& app) {
  CLI::App* paper = app.add_subcommand("paper", "the published figures beside the twin's and ours");
  auto arguments = std::make_shared<PaperArguments>();
  std::vector<std::string> names;
  for (const SectionEntry& entry : kSections) names.emplace_back(entry.name);
  paper->add_option("section", arguments->only, "only this one")->check(console::OneOf(names));
  paper->add_option("--json", arguments->json,
                    "write {name, commit, machine, rows, tables} here as well; scripts/plot draws it");
  paper->add_option("--seed", arguments->options.seed, "of the first rig")->capture_default_str();
  paper->add_option("--rigs", arguments->options.rigs, "simulated devices, pooled")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  paper->add_option("--poses", arguments->options.poses, "per rig and condition")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  paper->callback([arguments] { throw CLI::RuntimeError(RunPaper(*arguments)); });
}

}  // namespace omni::bench
