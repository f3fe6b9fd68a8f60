#include "service/haptics/sculpt/sculpt_query.h"

#include "service/haptics/geometry/query_in_tree.h"

namespace omni::haptics {

using sculpt::SculptSurface;

template NearestResult NearestInTree(const SculptSurface&, std::uint32_t, const Vec3&, double, std::uint32_t) noexcept;
template NearestResult NearestFaceInTree(const SculptSurface&, std::uint32_t, const Vec3&, double,
                                         const FacesTowards&) noexcept;
template CrossingResult CrossingInTree(const SculptSurface&, std::uint32_t, const Vec3&, const Vec3&, bool,
                                       const Skipped&) noexcept;
template bool IsInsideByWinding(const SculptSurface&, std::uint32_t, const Vec3&) noexcept;
template double SideOf(const SculptSurface&, const NearestResult&, const Vec3&) noexcept;

}  // namespace omni::haptics

namespace omni::haptics::sculpt {

NearestResult FindAgain(const SculptSurface& surface, const Vec3& point_base_m, const Vec3& normal,
                        double reach_m) noexcept {
  const auto faces_alike = [&](std::uint32_t triangle, const ClosestPoint&) noexcept {
    return Dot(AreaVector(surface.TriangleCorners(triangle)), normal) >= 0;
  };
  const NearestResult same = NearestAccepted(surface, 0, point_base_m, reach_m, kNoIndex, faces_alike);
  return same.triangle != kNoIndex ? same : NearestInTree(surface, 0, point_base_m);
}

}  // namespace omni::haptics::sculpt
