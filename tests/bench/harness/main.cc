// omni-bench: benchmarks, stress runs and the published figures. Everything simulated is simulated by the digital twin.
#include <cstdint>
#include <exception>
#include <iostream>
#include <memory>
#include <string>

#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/commands.h"

namespace omni::bench {
namespace {

struct Bench {
  const char* name;
  const char* about;
  base::Result<BenchRows> (*run)(const BenchOptions&);
};

constexpr Bench kBenches[] = {
    {"loop", "one tick of the service, per scene (the twin's time excluded)", BenchLoop},
    {"tick", "one tick in demanding scenes, features on and off, and beside busy threads", BenchTick},
    {"scene", "cost of loading a scene: bytes read, images, threads, memory, time", BenchScene},
    {"ipc", "OpenXR calls through the layer, and reads of the state memory", BenchIpc},
    {"layer", "the OpenXR layer: cost of calls, memory, latency, error of predicted poses", BenchLayer},
    {"tracking", "error of the tracker against the twin", BenchTracking},
    {"numbers", "every number of the tracker's options, scaled by .7 and 1.4, on the same scans (a simulation)",
     BenchNumbers},
    {"room", "tracking beside steel, magnets, bad sensors and in a field that changes (a simulation)", BenchRoom},
    {"dynamics", "tracking of a pen that starts, stops, trembles and rests (a simulation)", BenchDynamics},
    {"solver", "run time and error of solvers on the same poses", BenchSolver},
    {"stress", "bad input, basins, singular poses and long runs", BenchStress},
    {"calibration", "self-calibration of ten uncalibrated bases (a simulation)", BenchCalibration},
    {"align", "alignment of the base in a headset's space: error by method (a simulation)", BenchAlign},
    {"force", "the force map against the twin, by model and gap, and its cost", BenchForce},
    {"kernels", "the vector kernels of tracker, actuation and twin, by instruction set and precision", BenchKernels},
    {"collision", "contact with rigid meshes, compared with four engines: time, correctness, memory", BenchCollision},
    {"latency", "latency from a sensor's sample to the current that responds to it", BenchLatency},
    {"stability", "walls that are stable for a simulated hand, and the stiffness the renderer allows", BenchStability},
    {"hands", "walls that ordinary hands keep: rhythmic presses, tremor, ridges, taps (a simulation)", BenchHands},
    {"friction", "cone, stick-slip and drift against Coulomb's law", BenchFriction},
    {"texture", "gratings that a hand strokes: the delivered ripple by place (a simulation)", BenchTexture},
    {"tips", "a point and balls over thirty bodies: missed and false contacts, the side of the surface, time",
     BenchTips},
    {"sides", "bodies with cracks, holes, bow ties, through each other, of loose triangles: what is missed",
     BenchSides},
    {"race", "commanded and rendered hits of the car; walls and cost of the race", BenchRace},
    {"deformable", "soft bodies against a neo-Hookean reference, and their cost", BenchDeformable},
    {"sculpt", "cost of strokes and of publishing them, undo, and the force under the tip", BenchSculpt},
    {"surfaces", "displaying surfaces that change: snapshot, vertices, shared memory, a client's copy", BenchSurfaces},
    {"thermal", "the paper's heat runs on the twin and in the host's model", BenchThermal},
};

int RunBench(const Bench& bench, const BenchOptions& options, const std::string& json_path) {
  auto rows = bench.run(options);
  if (!rows.ok()) return tools::Fail(std::string("omni-bench ") + bench.name, rows.error());
  BenchRows own = *rows;
  const auto tables = tools::TakeSideTables(own);
  std::cout << tools::RowTable(own);
  for (const auto& [name, side] : tables) std::cout << "\n" << name << "\n" << tools::RowTable(side);
  return KeepRows(bench.name, *rows, json_path);
}

constexpr std::uint64_t kMost = 1'000'000'000;  // of ticks and cold starts

void AddBenches(Command& app) {
  auto options = std::make_shared<BenchOptions>();
  auto json_path = std::make_shared<std::string>();
  for (const Bench& bench : kBenches) {
    Command sub = app.AddCommand(bench.name, bench.about);
    sub.Add("--json", *json_path, "write {name, commit, machine, rows} here as well");
    sub.Add("--ticks", options->ticks, "loop: ticks per scene; stress, collision: ticks in all")
        .Range(std::uint64_t{1000}, kMost);
    sub.Add("--seed", options->seed, "of the twin").Range(std::uint64_t{0}, 1000 * kMost);
    sub.Add("--quick", options->quick, "much less work, to check that it runs");
    sub.Add("--mesh", options->mesh, "collision: a .glb file instead of the bench's own bodies").ExistingFile();
    sub.Add("--cold-solves", options->cold_solves, "solver: cold starts to search for failures")
        .Range(std::uint64_t{1}, kMost);
    sub.Add("--condition", options->conditions,
            "room: only these conditions, separated by commas; numbers: only this one");
    sub.Add("--bases", options->bases, "numbers: so many").Range(std::uint64_t{1}, std::uint64_t{100});
    sub.Add("--number", options->numbers, "numbers: only these, separated by commas");
    sub.Add("--factor", options->factor, "numbers: scaled by it and its inverse instead of .7 and 1.4").Range(1.0, 1e9);
    sub.Add("--resume", options->resume,
            "numbers: keeps here what is done, and goes on from it; of the same numbers and factor");
    sub.Add("--hours", options->hours, "stress: virtual time of the drift run").Range(0.0, 1000.0);
    sub.SetAction([&bench, options, json_path] { return RunBench(bench, *options, *json_path); });
  }
}

int Run(int argc, const char* const* argv) {
  console::Program app("omni-bench", "omni-bench: cost and accuracy of Omni, compared with other methods and engines");
  app.RequireCommand();
  AddBenches(app);
  AddPaper(app);
  AddPaired(app);
  return app.Parse(argc, argv).value_or(console::kExitOk);
}

}  // namespace

}  // namespace omni::bench

int main(int argc, char** argv) {
  try {
    return omni::bench::Run(argc, argv);
  } catch (const std::exception& error) {
    return omni::console::Fail("omni-bench", error.what());
  }
}
