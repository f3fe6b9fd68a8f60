#include "service/tools/scene/scene.h"

#include <algorithm>
#include <cstdio>
#include <functional>

#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

using haptics::Material;
using haptics::SoftnessModel;

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

// Materials that some triangle has.
std::vector<Material> UsedMaterials(const haptics::Scene& scene) {
  std::vector<Material> used;
  if (scene.empty()) return used;
  std::vector<bool> seen(scene.materials().size(), false);
  for (const haptics::Triangle& t : scene.triangles()) seen[t.material] = true;
  for (std::size_t m = 0; m < seen.size(); ++m) {
    if (seen[m]) used.push_back(scene.materials()[m]);
  }
  return used;
}

// A feature that materials switch on with a number above 0.
struct MaterialFeature {
  const char* name;
  const char* off;
  const char* on;
  const char* unit;
  std::function<double(const Material&)> value;
};

const MaterialFeature kMaterialFeatures[] = {
    {"friction", "every staticFriction is 0", "coefficient up to ", "",
     [](const Material& m) { return m.static_friction; }},
    {"damping", "every damping is 0", "up to ", " N s/m", [](const Material& m) { return m.damping_Ns_m; }},
    {"viscosity", "no material uses it", "up to ", " N s/m", [](const Material& m) { return m.viscosity_Ns_m; }},
    {"grating", "no vibrotactileTexture.amplitude", "amplitude up to ", " mm",
     [](const Material& m) { return 1e3 * m.texture_amplitude_m; }},
    {"relief", "no relief of a normalTexture", "gain up to ", "",
     [](const Material& m) { return m.relief >= 0 ? m.relief_gain : 0; }},
    {"vibration", "no material uses it", "up to ", " N", [](const Material& m) { return m.vibration_amplitude_N; }},
    {"popThrough", "no material uses it", "above ", " N", [](const Material& m) { return m.pop_through_N; }},
    {"magnet", "no material uses it", "up to ", " N", [](const Material& m) { return m.magnet_max_force_N; }},
};

SceneFeature ByMaterial(const MaterialFeature& feature, const std::vector<Material>& used) {
  double largest = 0;
  for (const Material& m : used) largest = std::max(largest, feature.value(m));
  if (largest <= 0) return {feature.name, false, feature.off};
  return {feature.name, true, feature.on + Short(largest) + feature.unit};
}

template <class Is>
std::size_t CountOf(const std::vector<Material>& used, Is is) {
  return static_cast<std::size_t>(std::count_if(used.begin(), used.end(), is));
}

SceneFeature Softness(const std::vector<Material>& used, const haptics::LivePlan& plan) {
  const std::size_t layers =
      CountOf(used, [](const Material& m) { return m.softness.model == SoftnessModel::kWinkler; });
  const std::size_t bodies = CountOf(used, [](const Material& m) { return m.softness.model == SoftnessModel::kTet; });
  if (layers + bodies == 0) return {"softness", false, "no material uses it: costs no memory and no thread"};
  std::string why = Plural(layers, "winkler material") + ", " + Plural(bodies, "tet material");
  if (!plan.soft.empty()) {
    const haptics::SoftBodyOptions options;
    const double most_MB = static_cast<double>(plan.soft.size() * haptics::MostSoftBytes(options)) * 1e-6;
    why += ": " + std::to_string(plan.soft.size()) + (plan.soft.size() == 1 ? " soft body" : " soft bodies") +
           " of at most " + std::to_string(options.lattice.max_surface_vertices) + " nodes, " + Short(most_MB) + " MB";
  }
  return {"softness", true, why};
}

SceneFeature Sculpted(const haptics::Scene& scene, const std::vector<Material>& used, const haptics::LivePlan& plan) {
  const std::size_t materials = CountOf(used, [](const Material& m) { return m.sculpt.enabled; });
  if (materials == 0) return {"sculpt", false, "no material is sculptable: costs no memory and no thread"};
  std::size_t triangles = 0;
  for (const std::uint32_t object : plan.sculpted) triangles += scene.objects()[object].triangle_count;
  return {"sculpt", !plan.sculpted.empty(),
          Plural(plan.sculpted.size(), "object") + ", " + Plural(triangles, "triangle") + ", about " +
              Short(static_cast<double>(haptics::SculptSessionBytes(scene, plan)) * 1e-6) + " MB of pages"};
}

SceneFeature Images(const haptics::Scene& scene) {
  const std::size_t textures = scene.empty() ? 0 : scene.textures().size();
  if (textures == 0) return {"textures", false, "no tag names an image"};
  return {"textures", true, Plural(textures, "texture") + ", " + Plural(scene.texels().size(), "texel")};
}

SceneFeature Collision(const LoadedScene& loaded) {
  if (loaded.load.skipped) return {"collision", false, "the file has no haptic tag (--touch-all touches all of it)"};
  std::size_t touched = 0;
  for (const haptics::Object& object : loaded.scene.objects()) touched += (object.flags & haptics::kCollidable) != 0;
  return {"collision", touched > 0,
          Plural(touched, "object") + ", " + Plural(loaded.scene.triangles().size(), "triangle")};
}

SceneFeature Kinematic(const haptics::Scene& scene) {
  std::size_t moved = 0;
  if (!scene.empty()) {
    for (const haptics::Object& object : scene.objects()) moved += (object.flags & haptics::kKinematic) != 0;
  }
  if (moved == 0) return {"kinematic", false, "no object is kinematic"};
  return {"kinematic", true, Plural(moved, "object") + " that the application moves"};
}

}  // namespace

std::vector<SceneFeature> FeaturesOf(const LoadedScene& loaded) {
  const haptics::Scene& scene = loaded.scene;
  const haptics::SceneHeader nothing{};
  const haptics::SceneHeader& header = scene.empty() ? nothing : scene.header();
  const std::vector<Material> used = UsedMaterials(scene);
  std::vector<SceneFeature> features{Collision(loaded)};
  for (const MaterialFeature& feature : kMaterialFeatures) features.push_back(ByMaterial(feature, used));
  features.push_back(Images(scene));
  const haptics::LivePlan plan = haptics::PlanLive(scene);
  features.push_back(Softness(used, plan));
  features.push_back(Sculpted(scene, used, plan));
  features.push_back(
      {"extrude", header.region_count > 0,
       header.region_count > 0 ? Plural(header.region_count, "face") : std::string("no material has extrude")});
  features.push_back(Kinematic(scene));
  const bool joystick = header.has_joystick != 0, vehicle = header.has_vehicle != 0;
  features.push_back({"joystick", joystick, joystick ? "one" : "no node has the role \"joystick\""});
  features.push_back({"vehicle", vehicle, vehicle ? "one" : "no node has the role \"vehicle\""});
  features.push_back({"ball tip", header.tip_radius_m > 0,
                      header.tip_radius_m > 0 ? Short(1e3 * header.tip_radius_m) + " mm"
                                              : std::string("the scene has no tip.radius: the tip is a point")});
  features.push_back({"threads", !plan.sculpted.empty(),
                      plan.sculpted.empty() ? "none for this scene; it is built on the service's builder thread"
                                            : "one that edits the surface, while an application uses this scene"});
  return features;
}

}  // namespace omni::tools
