#include "tests/bench/bombs/geometry.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/bench/bombs/measure.h"
#include "tests/support/mesh_bombs.h"

namespace omni::bombs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRuns = 3;

// Of several runs: the middle of the times, the most memory, the worst end.
Cost MiddleOf(std::array<Cost, kRuns> runs) {
  std::sort(runs.begin(), runs.end(), [](const Cost& a, const Cost& b) { return a.seconds < b.seconds; });
  Cost middle = runs[kRuns / 2];
  for (const Cost& run : runs) {
    middle.memory_MB = std::max(middle.memory_MB, run.memory_MB);
    if (run.end != "loaded") middle.end = run.end;
  }
  return middle;
}

}  // namespace

bool RunGeometry(const GeometryOptions& options) {
  const std::string omni = (options.bin / "omni").string();
  const fs::path mesh_path = options.folder / "mesh.glb", ball_path = options.folder / "ball.glb";
  const auto explain = [&](const fs::path& path) {
    return RunCommand({omni, "scene", "explain", "--no-cache", path.string()}, options.limit_s);
  };
  nlohmann::json rows = nlohmann::json::array();
  bool all_loaded = true;
  std::printf("%-26s %9s  %-8s %8s %8s  %8s %8s  %s\n", "omni scene explain", "triangles", "", "s", "MB", "ball, s",
              "ball, MB", "ratio");
  for (const std::size_t triangles : options.triangles) {
    for (const test::MeshBomb& bomb : test::kMeshBombs) {
      std::size_t count = 0;
      {
        const test::Soup mesh = bomb.make(triangles);
        count = mesh.triangles.size();
        std::ofstream(mesh_path, std::ios::binary) << test::MeshFile(mesh);
        std::ofstream(ball_path, std::ios::binary) << test::MeshFile(test::kCleanMesh.make(count));
      }
      std::array<Cost, kRuns> bombs, balls;
      for (std::size_t run = 0; run < kRuns; ++run) {  // in turn: both have the same neighbours on the machine
        bombs[run] = explain(mesh_path);
        balls[run] = explain(ball_path);
      }
      const Cost cost = MiddleOf(bombs), ball = MiddleOf(balls);
      const double ratio = cost.seconds / ball.seconds;
      all_loaded = all_loaded && cost.end == "loaded" && ball.end == "loaded";
      std::printf("%-26s %9zu  %-8s %8.3f %8.0f  %8.3f %8.0f  %.1f\n", bomb.name, count, cost.end.c_str(), cost.seconds,
                  cost.memory_MB, ball.seconds, ball.memory_MB, ratio);
      std::fflush(stdout);
      rows.push_back({{"kind", "geometry"},
                      {"mesh", bomb.name},
                      {"triangles", count},
                      {"end", cost.end},
                      {"seconds", cost.seconds},
                      {"memory_MB", cost.memory_MB},
                      {"ball_seconds", ball.seconds},
                      {"ball_memory_MB", ball.memory_MB},
                      {"ratio", ratio}});
    }
  }
  if (!options.json.empty()) std::ofstream(options.json) << rows.dump(1) << "\n";
  return all_loaded;
}

}  // namespace omni::bombs
