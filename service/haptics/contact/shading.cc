#include "service/haptics/contact/shading.h"

#include "service/haptics/contact/proxy.h"

namespace omni::haptics {
namespace {

// Do facets with these area vectors belong to one smooth face?
bool MeetSmoothly(const Vec3& a, const Vec3& b) noexcept {
  const double dot = Dot(a, b);
  return dot > 0 && dot * dot > kSmoothCosine * kSmoothCosine * SquaredNorm(a) * SquaredNorm(b);
}

bool AreCoplanar(const Vec3& a, const Vec3& b) noexcept {
  const double dot = Dot(a, b);
  return dot > 0 && dot * dot >= (1 - 1e-12) * SquaredNorm(a) * SquaredNorm(b);
}

// Sums facet normals around one corner of a triangle, as far as facets meet smoothly.   (13.1)
template <MeshView View>
class SmoothFan {
 public:
  SmoothFan(const View& view, std::uint32_t triangle, int corner) noexcept
      : view_(view), start_(triangle), vertex_(view.GetTriangle(triangle).vertex[corner]) {
    start_area_ = Add(triangle, corner);
    // Across the edge that leaves the vertex, then, unless that led around, across the one that enters it.
    closed_ = Walk(0);
    if (!closed_) Walk(2);
  }

  // Not normalized; zero only if all facets have no area.
  const Vec3& normal() const noexcept { return sum_; }
  bool flat() const noexcept { return flat_; }      // all facets lie in the plane of the first
  bool closed() const noexcept { return closed_; }  // all around the vertex, without a sharp edge or a border

 private:
  // [Max 1999]: with the weight sin / (|e1| |e2|) the sum is exact for vertices on any sphere.
  Vec3 Add(std::uint32_t triangle, int corner) noexcept {
    const Corners c = view_.TriangleCorners(triangle);
    const Vec3& apex = c[static_cast<std::size_t>(corner)];
    const Vec3 e1 = c[static_cast<std::size_t>((corner + 1) % 3)] - apex;
    const Vec3 e2 = c[static_cast<std::size_t>((corner + 2) % 3)] - apex;
    const Vec3 area = Cross(e1, e2);
    const double squares = SquaredNorm(e1) * SquaredNorm(e2);
    if (squares > 0) sum_ = sum_ + (1 / squares) * area;
    return area;
  }

  // True if the walk came back to where it began.
  bool Walk(int step) noexcept {
    std::uint32_t current = start_;
    Vec3 area = start_area_;
    for (int left = kMaxRing; left > 0; --left) {
      const auto& t = view_.GetTriangle(current);
      const std::uint32_t next = t.neighbour[(CornerOf(t, vertex_) + step) % 3];
      if (next == kNoIndex) return false;
      const Vec3 next_area = AreaVector(view_.TriangleCorners(next));
      if (!MeetSmoothly(area, next_area)) return false;
      if (next == start_) return true;
      Add(next, CornerOf(view_.GetTriangle(next), vertex_));
      flat_ = flat_ && AreCoplanar(start_area_, next_area);
      current = next;
      area = next_area;
    }
    return false;
  }

  const View& view_;
  const std::uint32_t start_, vertex_;
  Vec3 start_area_, sum_;
  bool flat_ = true, closed_ = false;
};

// `v` turned towards `axis` (both unit) until they are within the angle of `cosine`.   (13.3)
Vec3 TurnedTowards(const Vec3& v, const Vec3& axis, double cosine) noexcept {
  const double along = Dot(v, axis);
  if (along >= cosine) return v;
  const Vec3 across = Normalized(v - along * axis);
  return Normalized(cosine * axis + std::sqrt(1 - cosine * cosine) * across);
}

// True if the surface is smooth across the feature.
template <MeshView View>
bool IsSmoothAt(const View& view, std::uint32_t triangle, Feature feature, int index) noexcept {
  if (feature == Feature::kFace) return true;
  if (feature == Feature::kVertex) return SmoothFan<View>(view, triangle, index).closed();
  const std::uint32_t other = view.GetTriangle(triangle).neighbour[index];
  return other != kNoIndex &&
         MeetSmoothly(AreaVector(view.TriangleCorners(triangle)), AreaVector(view.TriangleCorners(other)));
}

}  // namespace

template <MeshView View>
Vec3 ShadedNormal(const View& view, std::uint32_t triangle, const std::array<double, 3>& weights) noexcept {
  const Vec3 facet = FaceNormal(view, triangle);
  Vec3 sum;
  bool flat = true;
  for (int k = 0; k < 3; ++k) {
    const double weight = weights[static_cast<std::size_t>(k)];
    if (!(weight > 0)) continue;
    const SmoothFan<View> fan(view, triangle, k);
    flat = flat && fan.flat();
    sum = sum + weight * Normalized(fan.normal());
  }
  if (flat) return facet;
  return TurnedTowards(Normalized(sum), facet, kSmoothCosine);
}

template <MeshView View>
Vec3 ShadedDirection(const View& view, std::uint32_t triangle, const ClosestPoint& at, const Vec3& direction) noexcept {
  if (!IsSmoothAt(view, triangle, at.feature, at.index)) return direction;
  const Vec3 facet = FaceNormal(view, triangle), shaded = ShadedNormal(view, triangle, at.weights);
  if (shaded == facet) return direction;
  return Dot(direction, facet) >= 0 ? shaded : -shaded;
}

template Vec3 ShadedNormal(const Surface&, std::uint32_t, const std::array<double, 3>&) noexcept;
template Vec3 ShadedDirection(const Surface&, std::uint32_t, const ClosestPoint&, const Vec3&) noexcept;
template Vec3 ShadedDirection(const sculpt::SculptSurface&, std::uint32_t, const ClosestPoint&, const Vec3&) noexcept;

}  // namespace omni::haptics
