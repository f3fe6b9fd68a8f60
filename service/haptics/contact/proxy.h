// The proxy: a point on the surface that follows the device point by local descent and never loses contact by itself.
// docs/theory/haptics.md, section 2.
#pragma once

#include "service/haptics/geometry/topology.h"

namespace omni::haptics {

inline constexpr int kMaxMoves = 64;  // triangles the proxy may cross in a tick; it goes on in the next

struct ProxyPoint {
  std::uint32_t triangle = kNoIndex;
  ClosestPoint closest;
};

// Moves from `start_triangle` to a local minimum of the distance to `target` over the surface.
template <MeshView View>
ProxyPoint DescendOnSurface(const View& view, std::uint32_t start_triangle, const Vec3& target) noexcept;

// Pseudonormal at the proxy, out of the surface whatever the side. Around a vertex it costs a walk.
template <MeshView View>
Vec3 NormalAt(const View& view, const ProxyPoint& proxy) noexcept {
  return Pseudonormal(view, proxy.triangle, proxy.closest.feature, proxy.closest.index);
}

enum class ProxyVerdict { kInside, kOutside, kOverBorder };

// Is the tip still behind the surface at its proxy? `side` +1: front is outside, -1: entered from the back.
template <MeshView View>
ProxyVerdict ClassifyProxy(const View& view, const ProxyPoint& proxy, const Vec3& tip, double side) noexcept;

inline constexpr double kSmoothCosine = 0.82;  // 35 degrees: triangles that meet at less belong to one smooth face

// Only what touches the feature the closest point lies on may take over: across the edge, or around the vertex.
// Searching further would jump over creases by one triangle size and make the force depend on the tessellation.   (2.1)
template <MeshView View>
class Descent {
 public:
  Descent(const View& view, std::uint32_t start_triangle, const Vec3& target) noexcept
      : view_(view), target_(target), best_{start_triangle, Closest(start_triangle)} {}

  ProxyPoint Run() noexcept {
    for (int move = 0; move < kMaxMoves; ++move) {
      const std::uint32_t from = best_.triangle;
      const auto& t = view_.GetTriangle(from);
      if (best_.closest.feature == Feature::kFace) {
        SearchBesides(from);
      } else if (best_.closest.feature == Feature::kEdge) {
        const std::uint32_t other = t.neighbour[best_.closest.index];
        if (other != kNoIndex) Consider(other);
      } else {
        SearchRing(from, t.vertex[best_.closest.index]);
      }
      if (best_.triangle == from) break;
    }
    return best_;
  }

 private:
  ClosestPoint Closest(std::uint32_t triangle) const noexcept {
    return ClosestOnTriangle(view_.TriangleCorners(triangle), target_);
  }
  void Consider(std::uint32_t triangle) noexcept {
    const ClosestPoint closest = Closest(triangle);
    if (closest.distance_squared < best_.closest.distance_squared) best_ = {triangle, closest};
  }
  // Inside a curved body every facet is a minimum of its own. Among facets of one smooth face, and only those, the
  // nearest wins.
  void SearchBesides(std::uint32_t from) noexcept {
    const auto& t = view_.GetTriangle(from);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = t.neighbour[k];
      if (other == kNoIndex) continue;
      const ClosestPoint closest = Closest(other);
      if (!(closest.distance_squared < best_.closest.distance_squared)) continue;
      if (Dot(FaceNormal(view_, from), FaceNormal(view_, other)) > kSmoothCosine) best_ = {other, closest};
    }
  }
  // A triangle of the fan comes nearer than the vertex only if one of its two edges there leads towards the target.
  void SearchRing(std::uint32_t start, std::uint32_t vertex) noexcept {
    const Vec3 apex = view_.VertexPosition(vertex);
    const Vec3 wanted = target_ - apex;
    WalkRing(view_, start, vertex, [&](std::uint32_t fan, int corner) noexcept {
      const auto& t = view_.GetTriangle(fan);
      const Vec3 e1 = view_.VertexPosition(t.vertex[(corner + 1) % 3]) - apex;
      const Vec3 e2 = view_.VertexPosition(t.vertex[(corner + 2) % 3]) - apex;
      if (Dot(e1, wanted) > 0 || Dot(e2, wanted) > 0) Consider(fan);
    });
  }

  const View& view_;
  const Vec3 target_;
  ProxyPoint best_;
};

template <MeshView View>
ProxyPoint DescendOnSurface(const View& view, std::uint32_t start_triangle, const Vec3& target) noexcept {
  return Descent<View>(view, start_triangle, target).Run();
}

template <MeshView View>
ProxyVerdict ClassifyProxy(const View& view, const ProxyPoint& proxy, const Vec3& tip, double side) noexcept {
  const Vec3 offset = tip - proxy.closest.point;
  if (proxy.closest.feature == Feature::kFace) {  // the same predicate by which a sweep decides
    const Corners corners = view.TriangleCorners(proxy.triangle);
    return side * ScaledHeight(corners, AreaVector(corners), tip) > 0 ? ProxyVerdict::kOutside : ProxyVerdict::kInside;
  }
  const Vec3 normal = NormalAt(view, proxy);
  const double height = side * Dot(offset, normal);
  if (height > 0 || (height == 0 && proxy.closest.distance_squared > 0)) return ProxyVerdict::kOutside;
  if (OnBorder(view, proxy.triangle, proxy.closest.feature, proxy.closest.index)) {
    // Beyond the border: the tip is off to the side of the proxy, not straight behind it.
    const Vec3 sideways = offset - (side * height) * normal;
    if (SquaredNorm(sideways) > 1e-12 * proxy.closest.distance_squared + 1e-18) return ProxyVerdict::kOverBorder;
  }
  return ProxyVerdict::kInside;
}

extern template ProxyPoint DescendOnSurface(const Surface&, std::uint32_t, const Vec3&) noexcept;
extern template ProxyVerdict ClassifyProxy(const Surface&, const ProxyPoint&, const Vec3&, double) noexcept;

}  // namespace omni::haptics
