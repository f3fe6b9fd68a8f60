// A scene's surfaces as they are drawn: vertices and triangles from copies of what the tick knows. Pure functions, off
// the tick; the results are kept by the caller, so that their memory is reused.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "service/haptics/live/live_parts.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using DrawnVertex = std::array<float, 3>;  // base frame, m
using DrawnTriangle = std::array<std::uint32_t, 3>;

// An object whose shape or place changes.
struct ChangingObject {
  std::uint32_t object = 0;
  bool soft = false;      // its soft body is ready
  bool sculpted = false;  // it has a sculpt session
  bool extruded = false;  // it has extrudable faces
  bool moved = false;     // kinematic
  bool HasVertices() const noexcept { return soft || sculpted || extruded; }
  friend bool operator==(const ChangingObject&, const ChangingObject&) = default;
};

// In the order of the scene. Their number may grow while the scene is in use, as soft bodies become ready.
std::vector<ChangingObject> ChangingObjects(const Scene& scene);

// The scene's vertices that belong to one object, which follow one another, in the order in which its triangles first
// name them. A soft body's skin is in this order too.
struct VertexRange {
  std::uint32_t first = 0, count = 0;
};
VertexRange VerticesOf(const Scene& scene, std::uint32_t object) noexcept;

// The object's triangles, naming vertices of VerticesOf counted from 0.
void DrawnTriangles(const Scene& scene, std::uint32_t object, std::vector<DrawnTriangle>& triangles);

// One object at rest, made once: what DisplacedVertices needs beside the state.
struct RestObject {
  std::uint32_t object = 0;
  VertexRange range;
  std::vector<Vec3> vertices_base_m;
  std::vector<Float3> displacement_m;  // room to work in
};
RestObject RestOf(const Scene& scene, std::uint32_t object);

// What of the tick's state deforms surfaces.
struct DeformingState {
  std::span<const SoftTouch> soft;       // State::soft
  std::span<const RegionState> regions;  // State::regions
};

// The object's vertices now: at rest, plus the offsets of its extrudable faces and the displacement of its soft body.
// Returns the largest displacement of a vertex, m. `out`: as VerticesOf.
double DisplacedVertices(const Scene& scene, const DeformingState& state, RestObject& rest,
                         std::vector<DrawnVertex>& out);

// A sculpted surface without the gaps of its pages. Precondition: the table stays valid meanwhile.
void CompactSurface(const sculpt::SculptTable& table, std::vector<DrawnVertex>& vertices,
                    std::vector<DrawnTriangle>& triangles);

}  // namespace omni::haptics
