// A pad of clay over the base, a hand that sculpts it, and what `omni scene` makes of it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "service/scene/glb_save.h"
#include "service/scene/scene_file.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/service_process.h"

namespace omni::test {

inline constexpr double kTop_m = 0.056;  // 18 mm above the hull

// Onto the top, held, pulled up, away; and once more.
inline constexpr const char* kPressAndPull = R"({"name": "pull", "repeat": true, "waypoints": [
  {"s": 0, "tip_m": [0, 0, 0.075], "axis": [0, 0, -1]},
  {"s": 0.5, "tip_m": [0, 0, 0.062], "axis": [0, 0, -1]},
  {"s": 0.5, "tip_m": [0, 0, 0.050], "axis": [0, 0, -1]},
  {"s": 0.8, "tip_m": [0, 0, 0.050], "axis": [0, 0, -1]},
  {"s": 1.0, "tip_m": [0, 0, 0.066], "axis": [0, 0, -1]},
  {"s": 1.0, "tip_m": [0, 0, 0.066], "axis": [0, 0, -1]},
  {"s": 0.15, "tip_m": [0, 0, 0.13], "axis": [0, 0, -1]},
  {"s": 0.5, "tip_m": [0, 0, 0.075], "axis": [0, 0, -1]}]})";

// A pad of clay, 12 n^2 triangles.
inline std::string ClayFile(const TempFolder& folder, int n = 16) {
  haptics::Material clay;
  clay.sculpt.enabled = true;
  clay.sculpt.grab_force_N = 0.15;
  clay.sculpt.dwell_s = 0.1;
  clay.sculpt.resistance_N_m = 60;
  haptics::InputObject pad = haptics::CubeGrid(n, [](const haptics::Vec3& p) {
    const haptics::Vec3 u = base::Normalized(p);
    return haptics::Vec3{0.02 * u.x, 0.02 * u.y, kTop_m - 0.007 + 0.007 * u.z};
  });
  pad.name = "pad";
  const std::string path = folder.Path("clay.glb");
  EXPECT_TRUE(scene::SaveGlb(path, haptics::SceneOf(pad, clay)).ok());
  return path;
}

inline Outcome OmniScene(const ServiceProcess& service, std::vector<std::string> words) {
  words.insert(words.begin(), "scene");
  words.insert(words.end(), {"--socket", service.socket_path()});
  return RunOmni(words);
}

inline double TopOf(const std::string& glb) {
  scene::LoadReport report;
  const auto loaded = scene::LoadSceneFile(glb, {}, report);
  if (!loaded.ok() || loaded->objects.size() != 1) return std::nan("");
  double top_m = 0;
  for (const base::Vec3& v : loaded->objects[0].vertices_base_m) top_m = std::max(top_m, v.z);
  return top_m;
}

}  // namespace omni::test
