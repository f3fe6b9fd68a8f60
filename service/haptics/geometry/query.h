// Queries on the tree of one object: nearest point, first crossing of a segment. No allocation; stacks are fixed,
// because the builder guarantees kMaxTreeDepth. Floats exclude (tree_lanes.h), doubles decide: the result is exactly
// that of testing every triangle.
#pragma once

#include <limits>

#include "service/haptics/geometry/surface.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

struct NearestResult {
  std::uint32_t triangle = kNoIndex;  // kNoIndex: nothing within the distance
  ClosestPoint closest;
};

struct CrossingResult {
  std::uint32_t triangle = kNoIndex;
  bool front = true;
  double t = 0;
};

// Components that a sweep does not count.
struct Skipped {
  const std::uint32_t* components = nullptr;
  int count = 0;
};

// Nearest point to `p` that is nearer than `max_distance_m`. `known`: a triangle thought to be near (the last answer),
// or kNoIndex; it makes the search shorter, and of equally near triangles it wins.
template <TreeView View>
NearestResult NearestInTree(const View& view, std::uint32_t root, const Vec3& p,
                            double max_distance_m = std::numeric_limits<double>::infinity(),
                            std::uint32_t known = kNoIndex) noexcept;

// Of the faces a point sees: triangles whose outward normal makes at least `cosine` with `direction`, and whose nearest
// point is seen along that normal (within 45 degrees) from behind.
struct FacesTowards {
  Vec3 direction;  // unit
  double cosine = -1;
};

// Nearest point on such a face that is nearer than `max_distance_m`.
template <TreeView View>
NearestResult NearestFaceInTree(const View& view, std::uint32_t root, const Vec3& p, double max_distance_m,
                                const FacesTowards& faces) noexcept;

// First triangle that the segment crosses. `both_sides` false: from the front only.
template <TreeView View>
CrossingResult CrossingInTree(const View& view, std::uint32_t root, const Vec3& start, const Vec3& end, bool both_sides,
                              const Skipped& skip = {}) noexcept;

// Inside by the winding number, wherever the object is not closed or its parts go through each other: the mean over
// directions of how often a ray from `p` leaves, less how often it enters   (1.10). Most rays decide.
template <TreeView View>
bool IsInsideByWinding(const View& view, std::uint32_t root, const Vec3& p) noexcept;
extern template bool IsInsideByWinding(const Surface&, std::uint32_t, const Vec3&) noexcept;

extern template NearestResult NearestInTree(const Surface&, std::uint32_t, const Vec3&, double, std::uint32_t) noexcept;
extern template NearestResult NearestFaceInTree(const Surface&, std::uint32_t, const Vec3&, double,
                                                const FacesTowards&) noexcept;
extern template CrossingResult CrossingInTree(const Surface&, std::uint32_t, const Vec3&, const Vec3&, bool,
                                              const Skipped&) noexcept;

// Distance from `p` to the object's box (0 inside): a lower bound of the distance to its surface.
double BoxDistance(const Object& object, const Vec3& p) noexcept;

// +1: p in front of the nearest point, -1: behind it (inside a closed object).
template <MeshView View>
double SideOf(const View& view, const NearestResult& nearest, const Vec3& p) noexcept;
extern template double SideOf(const Surface&, const NearestResult&, const Vec3&) noexcept;

}  // namespace omni::haptics
