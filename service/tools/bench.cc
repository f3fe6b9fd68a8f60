#include "service/tools/bench.h"

#include <sys/utsname.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>

#include "service/tools/command_line.h"
#include "service/tools/commands.h"
#include "service/tools/text_output.h"

namespace omni::tools {
namespace {

struct Bench {
  const char* name;
  const char* about;
  base::Result<BenchRows> (*run)(const BenchOptions&);
};

constexpr Bench kBenches[] = {
    {"loop", "one tick of the service, per scene (the twin's time excluded)", BenchLoop},
    {"tick", "one tick in demanding scenes, features on and off, and beside busy threads", BenchTick},
    {"scene", "what loading a scene costs: bytes read, images, threads, memory, time", BenchScene},
    {"ipc", "OpenXR calls through the layer, and reads of the state memory", BenchIpc},
    {"layer", "the OpenXR layer: cost of calls, memory, latency, error of predicted poses", BenchLayer},
    {"tracking", "error of the tracker against the twin", BenchTracking},
    {"solver", "run time and error of solvers on the same poses", BenchSolver},
    {"stress", "bad input, basins, singular poses and long runs", BenchStress},
    {"calibration", "self-calibration of ten uncalibrated bases (a simulation)", BenchCalibration},
    {"align", "where the base stands in a headset's space: error by method (a simulation)", BenchAlign},
    {"force", "the force map against the twin, by model and gap, and its cost", BenchForce},
    {"collision", "contact with rigid meshes beside four engines: time, correctness, memory", BenchCollision},
    {"latency", "from a sensor's sample to the current that answers it", BenchLatency},
    {"stability", "walls that a simulated hand can hold still against, and those that are offered", BenchStability},
    {"friction", "cone, stick-slip and drift against Coulomb's law", BenchFriction},
    {"race", "hits of the car against what the pen feels; walls and cost of the race", BenchRace},
    {"deformable", "soft bodies against a neo-Hookean reference, and their cost", BenchDeformable},
    {"sculpt", "cost of strokes and of publishing them, undo, and the force under the tip", BenchSculpt},
    {"surfaces", "showing surfaces that change: snapshot, vertices, shared memory, a client's copy", BenchSurfaces},
    {"thermal", "the paper's heat runs on the twin and in the host's model", BenchThermal},
};

std::string Machine() {
  std::string model = "unknown CPU";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    model = line.substr(line.find(':') + 2);
    break;
  }
  utsname system{};
  uname(&system);
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads, Linux " + system.release;
}

// What was typed, without --json FILE.
std::string CommandLine() {
  std::ifstream file("/proc/self/cmdline");
  std::string command = "omni";
  std::string word;
  std::getline(file, word, '\0');
  while (std::getline(file, word, '\0')) {
    if (word == "--json") {
      std::getline(file, word, '\0');
    } else {
      command += " " + word;
    }
  }
  return command;
}

std::string Cell(const nlohmann::ordered_json& value) {
  if (value.is_string()) return value;
  if (value.is_null()) return "-";
  if (!value.is_number_float()) return value.dump();
  char text[32];
  std::snprintf(text, sizeof(text), "%.3f", value.get<double>());
  return text;
}

// Side tables in the order of their first row; `rows` keeps the others.
std::vector<std::pair<std::string, BenchRows>> TakeSideTables(BenchRows& rows) {
  std::vector<std::pair<std::string, BenchRows>> tables;
  BenchRows kept;
  for (nlohmann::ordered_json& row : rows) {
    if (!row.contains("table")) {
      kept.push_back(row);
      continue;
    }
    const std::string name = row["table"];
    row.erase("table");
    const auto same = [&name](const auto& table) { return table.first == name; };
    auto found = std::find_if(tables.begin(), tables.end(), same);
    if (found == tables.end()) found = tables.insert(tables.end(), {name, {}});
    found->second.push_back(row);
  }
  rows = kept;
  return tables;
}

int RunBench(const Bench& bench, const BenchOptions& options, const std::string& json_path) {
  auto rows = bench.run(options);
  if (!rows.ok()) return Fail(std::string("omni bench ") + bench.name, rows.error());
  BenchRows own = *rows;
  const auto tables = TakeSideTables(own);
  std::cout << BenchTable(own);
  for (const auto& [name, side] : tables) std::cout << "\n" << name << "\n" << BenchTable(side);
  if (json_path.empty()) return kExitOk;
  const std::string problem = WriteText(json_path, BenchDocument(bench.name, *rows).dump(2) + "\n");
  return problem.empty() ? kExitOk : Fail("omni bench", problem);
}

}  // namespace

nlohmann::ordered_json BenchDocument(const std::string& name, const BenchRows& rows) {
  BenchRows own = rows;
  const auto tables = TakeSideTables(own);
  nlohmann::ordered_json document{
      {"name", name}, {"command", CommandLine()}, {"commit", OMNI_COMMIT}, {"machine", Machine()}, {"rows", own}};
  for (const auto& [table, side] : tables) document["tables"][table] = side;
  return document;
}

std::string BenchTable(const BenchRows& rows) {
  if (rows.empty()) return "no rows\n";
  std::vector<std::string> keys;
  for (const auto& [key, value] : rows.front().items()) keys.push_back(key);
  std::vector<std::vector<std::string>> lines{keys};
  for (const auto& row : rows) {
    std::vector<std::string> line;
    line.reserve(keys.size());
    for (const std::string& key : keys) line.push_back(Cell(row.value(key, nlohmann::ordered_json())));
    lines.push_back(line);
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t column = 0; column < keys.size(); ++column) {
      std::size_t width = 0;
      for (const auto& other : lines) width = std::max(width, other[column].size());
      text += line[column] + std::string(width + 2 - line[column].size(), ' ');
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  return text;
}

void AddBench(CLI::App& app) {
  CLI::App* bench_app = app.add_subcommand("bench", "benchmarks");
  bench_app->require_subcommand(1);
  auto options = std::make_shared<BenchOptions>();
  auto json_path = std::make_shared<std::string>();
  for (const Bench& bench : kBenches) {
    CLI::App* sub = bench_app->add_subcommand(bench.name, bench.about);
    sub->add_option("--json", *json_path, "write {name, commit, machine, rows} here as well");
    sub->add_option("--ticks", options->ticks, "loop: ticks per scene; stress, collision: ticks in all")
        ->check(CLI::Range(1000ULL, 1'000'000'000ULL));
    sub->add_option("--seed", options->seed, "of the twin")->check(CLI::Range(0ULL, 1'000'000'000'000ULL));
    sub->add_flag("--quick", options->quick, "much less work, to see that it runs");
    sub->add_option("--mesh", options->mesh, "collision: a .glb file instead of the bench's own bodies")
        ->check(CLI::ExistingFile);
    sub->add_option("--cold-solves", options->cold_solves, "solver: cold starts to search for failures")
        ->check(CLI::Range(1ULL, 1'000'000'000ULL));
    sub->add_option("--hours", options->hours, "stress: virtual time of the drift run")->check(CLI::Range(0.0, 1000.0));
    sub->callback([&bench, options, json_path] { throw CLI::RuntimeError(RunBench(bench, *options, *json_path)); });
  }
  AddBenchPlot(*bench_app);
  AddBenchPage(*bench_app);
}

}  // namespace omni::tools
