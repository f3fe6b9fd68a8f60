// What of a scene is to change while it is felt, and the parts that do it: workshops at once, soft bodies by whoever
// calls BuildSoftBody (deformable/build_soft_body.h) with what stands here. Off the tick. A scene without such tags
// costs a look at its materials.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/haptics/geometry/mesh.h"
#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene.h"

namespace omni::haptics {

// Object indices, ascending. `lines`: why an object that asks for it gets neither, a sentence each.
struct LivePlan {
  std::vector<std::uint32_t> soft;      // get a soft body
  std::vector<std::uint32_t> sculpted;  // get a workshop; at most kMaxSculpted
  std::vector<std::string> lines;
  bool empty() const noexcept { return soft.empty() && sculpted.empty(); }
};

// The material that most of an object's triangles have decides for all of it. Soft: collidable, softness model kTet.
// Sculpted: collidable, sculpt enabled, closed, not double-sided; the first kMaxSculpted. An object with extrudable
// faces gets neither.
LivePlan PlanLive(const Scene& scene);

// The material that most triangles have, of equal ones the first. Precondition: object.triangle_count > 0.
std::uint32_t MainMaterial(const Scene& scene, const Object& object);

// An object's triangles as they are in the scene, connected and oriented, base frame, m. Vertices in the scene's order.
// No texture coordinates.
Mesh MeshOf(const Scene& scene, std::uint32_t object);

// How BuildSoftBody is to make a body of this material. Poisson's ratio is taken to 0.49 at most; fibres without a
// direction count as none.
SoftBodyOptions SoftOptionsOf(const Material& material);

// How a material feels while it is formed. The resistance H (N/m) is what a hand meets: each millimetre costs H more.
// With it grow the force below which nothing gives way (that of one millimetre) and the viscosity, so that the surface
// follows within 20 ms whatever H is.
sculpt::SculptParameters SculptParametersOf(const Material& material);

// The brush of an object; its symmetry plane goes through the middle of the box around `mesh`.
sculpt::Brush BrushOf(const Sculpt& sculpt, const Mesh& mesh);

// A workshop for each of plan.sculpted. One that cannot be made stays out, with a line that says why.
void AddSculptSessions(const Scene& scene, const LivePlan& plan, LiveParts& live, std::vector<std::string>& lines);

// Plans, makes the workshops and gives the scene its LiveParts if anything is to change in it; soft bodies are left to
// the caller, who sets them later (LiveParts::SetSoftBody). `scene` is not in the tick yet.
LivePlan MakeLive(Scene& scene);

// The scene as it was before anybody sculpted it: new workshops, the same soft bodies. A scene without workshops shares
// its live parts with the copy.
Scene FreshCopy(const Scene& scene);

// What the tables between a soft body's nodes take at most, bytes; its skin adds 16 a vertex.
std::uint64_t MostSoftBytes(const SoftBodyOptions& options);
// What the freshly made workshops of plan.sculpted take, bytes, about.
std::uint64_t SculptSessionBytes(const Scene& scene, const LivePlan& plan);

}  // namespace omni::haptics
