// omni-bench paired: the tick's time before and after a change, on the default twin, a calibrated base in its room.
// Both programs replay the same recorded scans, each with its own calibration of that base, in the shipped scenes and
// in none; of each tick the least of many replays counts, which excludes other work of the machine: two builds of the
// same commit differ by a few hundredths of a microsecond, where the 99th percentile of single runs jumps by a half.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "service/config/files/twin_file.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/row_table.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/harness/commands.h"
#include "tests/support/rig/loop_replay.h"

namespace omni::bench {
namespace {

constexpr const char* kCommand = "omni-bench paired";
constexpr const char* kPairedScenes[] = {"extrusion", "dragon", "racetrack"};

struct PairedArguments {
  std::string folder, json;
  bool record = false;
  std::uint64_t seed = 1;
  int replays = 15;
};

using Scans = std::vector<base::HallScan>;

std::string ScansFile(const std::string& folder, const std::string& scene) { return folder + "/" + scene + ".scans"; }

// As in memory: for programs of one machine on one day.
std::string Write(const std::string& path, const Scans& scans) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(scans.data()),
             static_cast<std::streamsize>(scans.size() * sizeof(base::HallScan)));
  file.close();
  return file ? "" : path + ": cannot be written; check the folder";
}

base::Result<Scans> Read(const std::string& path) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error || bytes == 0 || bytes % sizeof(base::HallScan) != 0) {
    return base::Error{path + ": holds no scans of this version; make it with " + kCommand + " --record"};
  }
  Scans scans(bytes / sizeof(base::HallScan));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(scans.data()), static_cast<std::streamsize>(bytes));
  if (!file) return base::Error{path + ": cannot be read"};
  return scans;
}

nlohmann::ordered_json Play(const std::string& name, const loop::TickConfig& config, const haptics::Scene& scene,
                            const Scans& scans, int replays) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> least_us(scans.size(), 1e9);
  std::size_t touching = 0;
  for (int replay = 0; replay < replays; ++replay) {
    const auto player = std::make_unique<test::ScanPlayer>(config, scene, scans);
    player->Start();
    for (double& least : least_us) {
      const Clock::time_point begin = Clock::now();
      player->Tick();
      least = std::min(least, std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
      touching += replay == 0 && player->output().haptics.contact_count > 0;
    }
  }
  return {{"scene", name},
          {"ticks", scans.size()},
          {"touching", touching},
          {"replays", replays},
          {"least_us_median", tools::Quantile(least_us, 0.5)},
          {"least_us_p99", tools::Quantile(least_us, 0.99)},
          {"least_us_p999", tools::Quantile(least_us, 0.999)}};
}

int RunPaired(const PairedArguments& arguments) {
  loop::FlushDenormals();
  const auto config = test::CalibratedTick(arguments.seed);
  if (!config.ok()) return tools::Fail(kCommand, config.error());
  tools::Rows rows;
  for (const char* name : kPairedScenes) {
    const std::string path = tools::ShippedScene(name);
    auto loaded = tools::LoadLiveScene(path, {});
    if (!loaded.ok()) return tools::Fail(kCommand, loaded.error());
    const std::string file = ScansFile(arguments.folder, name);
    if (arguments.record) {
      const auto scans = test::RecordScans(*config, loaded->scene, path, arguments.seed, config::RoomTwin());
      if (!scans.ok()) return tools::Fail(kCommand, scans.error());
      if (const std::string problem = Write(file, *scans); !problem.empty()) return tools::Fail(kCommand, problem);
      continue;
    }
    const auto scans = Read(file);
    if (!scans.ok()) return tools::Fail(kCommand, scans.error());
    if (rows.empty()) rows.push_back(Play("none", *config, haptics::Scene(), *scans, arguments.replays));
    rows.push_back(Play(name, *config, loaded->scene, *scans, arguments.replays));
  }
  if (arguments.record) return tools::kExitOk;
  std::cout << tools::RowTable(rows);
  return KeepRows("paired", rows, arguments.json);
}

}  // namespace

void AddPaired(Command& app) {
  Command paired = app.AddCommand("paired", "one tick in the shipped scenes, to compare two builds on the same scans");
  auto arguments = std::make_shared<PairedArguments>();
  paired.Add("folder", arguments->folder, "of the recorded scans").Required().ExistingFolder();
  paired.Add("--record", arguments->record, "record them there (simulated by the digital twin) and time nothing");
  paired.Add("--seed", arguments->seed, "of the twin; the same for --record and the replays").ShowDefault();
  paired.Add("--replays", arguments->replays, "of each tick; the least counts").Range(1, 1000).ShowDefault();
  paired.Add("--json", arguments->json, "write {name, commit, machine, rows} here as well");
  paired.SetAction(arguments, RunPaired);
}

}  // namespace omni::bench
