#include "service/haptics/live/make_live.h"

#include <algorithm>
#include <string>

namespace omni::haptics {
namespace {

constexpr double kLargestPoisson = 0.49;  // CheckModuli's limit; files may say 0.499
constexpr double kHeldShare = 0.3;        // of a soft body's height is clamped: held by its foot alone, it would swing
constexpr double kYieldDepth_m = 1e-3;    // the surface yields at the force of this displacement ...
constexpr double kLeastYield_N = 0.05;    // ... at least this, so that it does not creep under a hand that rests ...
constexpr double kMostYield_N = 0.5;      // ... at most this, so that the hardest can still be formed
constexpr double kFollow_s = 0.02;        // viscosity over resistance
constexpr double kTear_m = 0.012;         // a hand that leads the surface by more has let go
constexpr double kLeastViscosity_Ns_m = 1.0;  // quiets the tracker's noise where nothing resists

bool AnyMaterialAsks(const Scene& scene) {
  const auto asks = [](const Material& m) { return m.sculpt.enabled || m.softness.model == SoftnessModel::kTet; };
  return std::any_of(scene.materials().begin(), scene.materials().end(), asks);
}

bool HasRegions(const Scene& scene, std::uint32_t object) {
  return std::any_of(scene.regions().begin(), scene.regions().end(),
                     [object](const Region& region) { return region.object == object; });
}

// Why this object cannot be sculpted; null: it can.
const char* WhyRigid(const Scene& scene, std::uint32_t index) {
  const Object& object = scene.objects()[index];
  if ((object.flags & kClosed) == 0) return "sculptable, but not closed; close its holes";
  if ((object.flags & kDoubleSided) != 0) return "sculptable, but double-sided; remove doubleSided";
  if (HasRegions(scene, index)) return "sculptable, but some of its faces are extruded; remove one of the two";
  return nullptr;
}

sculpt::Falloff FalloffOf(Falloff falloff) {
  switch (falloff) {
    case Falloff::kConstant:
      return sculpt::Falloff::kConstant;
    case Falloff::kLinear:
      return sculpt::Falloff::kLinear;
    case Falloff::kSmooth:
      break;
  }
  return sculpt::Falloff::kSmooth;
}

}  // namespace

std::uint32_t MainMaterial(const Scene& scene, const Object& object) {
  std::vector<std::uint32_t> count(scene.materials().size());
  for (const Triangle& t : scene.triangles().subspan(object.first_triangle, object.triangle_count)) ++count[t.material];
  return static_cast<std::uint32_t>(std::max_element(count.begin(), count.end()) - count.begin());
}

LivePlan PlanLive(const Scene& scene) {
  LivePlan plan;
  if (scene.empty() || !AnyMaterialAsks(scene)) return plan;
  for (std::uint32_t i = 0; i < scene.objects().size(); ++i) {
    const Object& object = scene.objects()[i];
    if ((object.flags & kCollidable) == 0 || object.triangle_count == 0) continue;
    const Material& material = scene.materials()[MainMaterial(scene, object)];
    const auto say = [&](const std::string& what) { plan.lines.push_back(std::string(object.name) + ": " + what); };
    if (material.sculpt.enabled) {
      if (const char* why = WhyRigid(scene, i)) {
        say(std::string(why) + ": it stays rigid");
      } else if (plan.sculpted.size() == kMaxSculpted) {
        say("sculptable, but a scene has at most " + std::to_string(kMaxSculpted) + " such objects: it stays rigid");
      } else {
        plan.sculpted.push_back(i);
      }
    } else if (material.softness.model == SoftnessModel::kTet) {
      if (HasRegions(scene, i)) {
        say("softness tet, but some of its faces are extruded; remove one of the two: it stays a layer");
      } else {
        plan.soft.push_back(i);
      }
    }
  }
  return plan;
}

Mesh MeshOf(const Scene& scene, std::uint32_t index) {
  const Object& object = scene.objects()[index];
  const auto triangles = scene.triangles().subspan(object.first_triangle, object.triangle_count);
  std::vector<std::uint32_t> renamed(scene.vertices().size(), kNoIndex);
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t.vertex) renamed[v] = 0;
  }
  Mesh mesh;
  for (std::uint32_t v = 0; v < renamed.size(); ++v) {
    if (renamed[v] == kNoIndex) continue;
    renamed[v] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back({scene.vertices()[v].x, scene.vertices()[v].y, scene.vertices()[v].z});
  }
  for (const Triangle& t : triangles) {
    mesh.triangles.push_back({renamed[t.vertex[0]], renamed[t.vertex[1]], renamed[t.vertex[2]]});
    mesh.material.push_back(t.material);
    mesh.component.push_back(t.component);
    auto& neighbours = mesh.neighbours.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      neighbours[k] = t.neighbour[k] == kNoIndex ? kNoIndex : t.neighbour[k] - object.first_triangle;
    }
  }
  return mesh;
}

SoftBodyOptions SoftOptionsOf(const Material& material) {
  const Softness& softness = material.softness;
  const auto& f = softness.fibre_direction_base;
  SoftBodyOptions options;
  options.moduli.young_modulus_Pa = softness.young_modulus_Pa;
  options.moduli.poisson_ratio = std::min(softness.poisson_ratio, kLargestPoisson);
  if (base::Norm({f[0], f[1], f[2]}) > 0) {
    options.moduli.fibre_ratio = softness.fibre_ratio;
    options.fibre = {f[0], f[1], f[2]};
  }
  options.clamped_share = kHeldShare;
  options.hardening = softness.hardening;
  options.relaxation_time_s = softness.relaxation_time_s;
  return options;
}

sculpt::SculptParameters SculptParametersOf(const Material& material) {
  const Sculpt& from = material.sculpt;
  sculpt::SculptParameters parameters;
  parameters.grab_force_N = from.grab_force_N;
  parameters.dwell_s = from.dwell_s;
  parameters.hardening_N_m = from.resistance_N_m;
  parameters.yield_N = std::clamp(from.resistance_N_m * kYieldDepth_m, kLeastYield_N, kMostYield_N);
  parameters.viscosity_Ns_m = std::max(from.resistance_N_m * kFollow_s, kLeastViscosity_Ns_m);
  parameters.stiffness_N_m = material.stiffness_N_m;
  parameters.tear_m = kTear_m;
  parameters.grid_step_m = from.snap_m;
  parameters.rest_s = from.rest_s;
  return parameters;
}

sculpt::Brush BrushOf(const Sculpt& from, const Mesh& mesh) {
  sculpt::Brush brush;
  brush.radius_m = from.radius_m;
  brush.falloff = FalloffOf(from.falloff);
  brush.symmetry.enabled = from.symmetry != Symmetry::kNone;
  if (!brush.symmetry.enabled || mesh.vertices.empty()) return brush;
  Vec3 lower = mesh.vertices[0], upper = lower;
  for (const Vec3& v : mesh.vertices) {
    lower = Min(lower, v);
    upper = Max(upper, v);
  }
  brush.symmetry.point_base_m = 0.5 * (lower + upper);
  brush.symmetry.normal = {from.symmetry == Symmetry::kX ? 1.0 : 0.0, from.symmetry == Symmetry::kY ? 1.0 : 0.0,
                           from.symmetry == Symmetry::kZ ? 1.0 : 0.0};
  return brush;
}

void AddSculptSessions(const Scene& scene, const LivePlan& plan, LiveParts& live, std::vector<std::string>& lines) {
  for (const std::uint32_t index : plan.sculpted) {
    const Object& object = scene.objects()[index];
    const Material& material = scene.materials()[MainMaterial(scene, object)];
    const Mesh mesh = MeshOf(scene, index);
    auto editor = sculpt::SculptEditor::Make(mesh, {.grid_step_m = material.sculpt.snap_m, .object = index});
    if (!editor.ok()) {
      lines.push_back(std::string(object.name) + ": " + editor.error() + ": it stays rigid");
      continue;
    }
    live.AddSculptSession(index, std::make_unique<sculpt::SculptSession>(
                                     std::move(*editor), SculptParametersOf(material), BrushOf(material.sculpt, mesh)));
  }
}

LivePlan MakeLive(Scene& scene, std::uint64_t most_bytes) {
  LivePlan plan = PlanLive(scene);
  while (SculptSessionBytes(scene, plan) > most_bytes) {
    const std::uint64_t all = SculptSessionBytes(scene, plan);
    const std::string name = scene.objects()[plan.sculpted.back()].name;
    plan.sculpted.pop_back();
    plan.lines.push_back(name + ": sculptable, which needs " +
                         std::to_string((all - SculptSessionBytes(scene, plan)) / 1'000'000 + 1) +
                         " MB more than scenes may take: it stays rigid; simplify it, or end other applications");
  }
  if (plan.empty()) return plan;
  auto live = std::make_shared<LiveParts>();
  AddSculptSessions(scene, plan, *live, plan.lines);
  if (!plan.soft.empty() || live->sculpt_session_count() > 0) scene.SetLive(std::move(live));
  return plan;
}

std::uint64_t MostSoftBytes(const SoftBodyOptions& options) {
  const std::uint64_t n = options.lattice.max_surface_vertices;
  return n * n * sizeof(Float3) + n * (n + 1) / 2 * sizeof(float);
}

std::uint64_t SculptSessionBytes(const Scene& scene, const LivePlan& plan) {
  std::uint64_t pages = 0;
  for (const std::uint32_t object : plan.sculpted) {
    pages += (scene.objects()[object].triangle_count + sculpt::kPageFill - 1) / sculpt::kPageFill;
  }
  return pages * sizeof(sculpt::Page);
}

}  // namespace omni::haptics
