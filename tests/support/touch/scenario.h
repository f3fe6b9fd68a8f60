// A scenario in virtual time: the twin's pen follows a path, the loop runs with a scene, the test checks every tick.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/config/files/device_file.h"
#include "service/device/transport.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/sim/twin/twin.h"

namespace omni::test {

// A closed box, its faces split n x n.
inline haptics::InputObject Box(const base::Vec3& centre, const base::Vec3& half, int n) {
  haptics::InputObject object;
  object.name = "box";
  const auto face = [&](const base::Vec3& normal, const base::Vec3& a, const base::Vec3& b) {
    const auto first = static_cast<std::uint32_t>(object.vertices_base_m.size());
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const double s = 2.0 * i / n - 1;
        const double t = 2.0 * j / n - 1;
        object.vertices_base_m.push_back({centre.x + half.x * (normal.x + s * a.x + t * b.x),
                                          centre.y + half.y * (normal.y + s * a.y + t * b.y),
                                          centre.z + half.z * (normal.z + s * a.z + t * b.z)});
      }
    }
    const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * (n + 1) + j); };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        object.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        object.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  };
  face({1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  face({-1, 0, 0}, {0, 0, 1}, {0, 1, 0});
  face({0, 1, 0}, {0, 0, 1}, {1, 0, 0});
  face({0, -1, 0}, {1, 0, 0}, {0, 0, 1});
  face({0, 0, 1}, {1, 0, 0}, {0, 1, 0});
  face({0, 0, -1}, {0, 1, 0}, {1, 0, 0});
  object.triangle_material.assign(object.triangles.size(), 0);
  return object;
}

// A table whose top is `top_m` above the core's centre, directly under the pen.
inline haptics::Scene TableScene(double top_m, double stiffness_N_m = 400) {
  haptics::SceneInput input;
  input.name = "table";
  input.materials.push_back({.stiffness_N_m = stiffness_N_m, .damping_Ns_m = 1});
  input.objects.push_back(Box({0, 0, top_m - 0.005}, {0.03, 0.03, 0.005}, 4));
  haptics::BuildReport report;
  return std::move(haptics::BuildScene(input, report).value());
}

inline constexpr double kTableTop_m = 0.055;

// Down onto the table, hold, slide along it, up again; 4 s.
inline sim::HandScript PressAndSlide() {
  sim::HandScript script;
  script.name = "press and slide";
  script.waypoints = {{.duration_s = 0, .tip_base_m = {0, 0, kTableTop_m + 0.015}},
                      {.duration_s = 0.8, .tip_base_m = {0, 0, kTableTop_m + 0.010}},
                      {.duration_s = 0.7, .tip_base_m = {0, 0, kTableTop_m - 0.006}},
                      {.duration_s = 0.8, .tip_base_m = {0, 0, kTableTop_m - 0.006}},
                      {.duration_s = 0.7, .tip_base_m = {0.012, 0, kTableTop_m - 0.006}},
                      {.duration_s = 0.7, .tip_base_m = {0, 0, kTableTop_m + 0.015}},
                      {.duration_s = 0.3, .tip_base_m = {0, 0, kTableTop_m + 0.015}}};
  return script;
}

class Scenario {
 public:
  explicit Scenario(const sim::HandScript& script, double seconds, std::uint64_t seed = 1)
      : config(loop::MakeTickConfig(config::DefaultDevice())),
        twin(sim::MakeVirtualTwin(config::DefaultDevice(), {.seed = seed, .script = script}, seconds)) {
    loop::FlushDenormals();
  }

  // Default commands: an owner with an open gate and the scene of generation 1.
  static loop::Commands Open(const base::HallScan& scan) {
    return {.t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
  }

  // One device tick. False: the run is over.
  bool Step(const haptics::Scene& scene, const std::function<loop::Commands(const base::HallScan&)>& commands = Open) {
    if (twin->Read(scan, 0) != device::ReadStatus::kScan) return false;
    if (state.tick == 0) loop::EnterScene(scene, 1, state);
    loop::Tick(config, scan, commands(scan), scene, state, output, feeds);
    twin->Write(output.currents);
    return true;
  }

  double force_N() const {
    const base::Vec3& f = output.wrench.force_N;
    return Norm(f);
  }
  double current_A() const {
    double largest = 0;
    for (const double i : output.currents.current_A) largest = std::max(largest, std::abs(i));
    return largest;
  }

  loop::TickConfig config;
  std::unique_ptr<device::Transport> twin;
  base::HallScan scan;
  loop::LoopState state;
  loop::TickFeeds feeds;
  loop::TickOutput output;
};

}  // namespace omni::test
