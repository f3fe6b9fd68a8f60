#include "tests/bench/tracking/pressed_box.h"

#include <utility>

namespace omni::bench {
namespace {

constexpr double kBox_m = 0.12, kBoxTop_m = 0.03;

}  // namespace

base::Result<haptics::Scene> PressedBox() {
  haptics::InputObject box;
  box.name = "box";
  for (const double z_m : {-0.02, kBoxTop_m}) {
    box.vertices_base_m.insert(
        box.vertices_base_m.end(),
        {{-kBox_m, -kBox_m, z_m}, {kBox_m, -kBox_m, z_m}, {kBox_m, kBox_m, z_m}, {-kBox_m, kBox_m, z_m}});
  }
  box.triangles = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4},
                   {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  box.triangle_material.assign(box.triangles.size(), 0);
  haptics::SceneInput input;
  input.name = "box";
  input.materials.emplace_back();
  input.objects.push_back(std::move(box));
  haptics::BuildReport report;
  return haptics::BuildScene(input, report);
}

}  // namespace omni::bench
