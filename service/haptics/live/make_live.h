// Which objects of a scene change while it is in use, and the parts for it: sculpt sessions at once, soft bodies by the
// caller of BuildSoftBody (deformable/build/build_soft_body.h) with these options. Off the tick. A scene without such
// tags costs one pass over its materials.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/haptics/geometry/mesh.h"
#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

// Object indices, ascending. `lines`: why a tagged object gets neither, one sentence each.
struct LivePlan {
  std::vector<std::uint32_t> soft;      // get a soft body
  std::vector<std::uint32_t> sculpted;  // get a sculpt session; at most kMaxSculpted
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

// How a material resists sculpting. The resistance H (N/m) is force per displacement of the surface. With it grow the
// force below which nothing gives way (that of one millimetre) and the viscosity, so that the surface follows within 20
// ms whatever H is.
sculpt::SculptParameters SculptParametersOf(const Material& material);

// The brush of an object; its symmetry plane goes through the middle of the box around `mesh`.
sculpt::Brush BrushOf(const Sculpt& sculpt, const Mesh& mesh);

// A sculpt session for each of plan.sculpted. One that cannot be made is left out, with a line that says why.
void AddSculptSessions(const Scene& scene, const LivePlan& plan, LiveParts& live, std::vector<std::string>& lines);

// Plans, makes the sculpt sessions and gives the scene its LiveParts if anything is to change in it; soft bodies are
// left to the caller, who sets them later (LiveParts::SetSoftBody). `scene` is not in the tick yet. Sculpt sessions
// that would take more than `most_bytes` are left out, with a line.
LivePlan MakeLive(Scene& scene, std::uint64_t most_bytes = UINT64_MAX);

// Largest memory of the tables between a soft body's nodes, bytes; its skin adds 16 per vertex.
std::uint64_t MostSoftBytes(const SoftBodyOptions& options);
// Approximate memory of new sculpt sessions for plan.sculpted, bytes.
std::uint64_t SculptSessionBytes(const Scene& scene, const LivePlan& plan);

}  // namespace omni::haptics
