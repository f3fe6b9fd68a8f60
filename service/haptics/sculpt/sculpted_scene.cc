#include "service/haptics/sculpt/sculpted_scene.h"

#include "service/haptics/scene/scene.h"

namespace omni::haptics::sculpt {

SceneInput SculptedScene(const Scene& scene, const LiveParts& live) {
  SceneInput saved;
  saved.name = scene.header().name;
  std::vector<std::uint32_t> renamed(scene.materials().size(), kNoIndex);
  for (std::uint32_t n = 0; n < live.sculpt_session_count(); ++n) {
    Mesh mesh = live.sculpt_session_at(n).editor().Snapshot();
    for (std::uint16_t& m : mesh.material) {
      if (renamed[m] == kNoIndex) {
        renamed[m] = static_cast<std::uint32_t>(saved.materials.size());
        saved.materials.emplace_back(scene.materials()[m]).ForgetImages();
      }
      m = static_cast<std::uint16_t>(renamed[m]);
    }
    InputObject& object = saved.objects.emplace_back();
    object.name = scene.objects()[live.object_at(n)].name;
    object.vertices_base_m = std::move(mesh.vertices);
    object.triangles = std::move(mesh.triangles);
    object.triangle_material = std::move(mesh.material);
    object.car_wall = (scene.objects()[live.object_at(n)].flags & kCarWall) != 0;
  }
  return saved;
}

}  // namespace omni::haptics::sculpt
