#include "service/haptics/geometry/query.h"

#include "service/haptics/geometry/query_in_tree.h"
#include "service/haptics/geometry/topology.h"

namespace omni::haptics {

template NearestResult NearestInTree(const Surface&, std::uint32_t, const Vec3&, double, std::uint32_t) noexcept;
template NearestResult NearestFaceInTree(const Surface&, std::uint32_t, const Vec3&, double,
                                         const FacesTowards&) noexcept;
template CrossingResult CrossingInTree(const Surface&, std::uint32_t, const Vec3&, const Vec3&, bool,
                                       const Skipped&) noexcept;
template bool IsInsideByWinding(const Surface&, std::uint32_t, const Vec3&) noexcept;
template double SideOf(const Surface&, const NearestResult&, const Vec3&) noexcept;

double BoxDistance(const Object& object, const Vec3& p) noexcept {
  const auto outside = [](double lower, double upper, double x) noexcept {
    return x < lower ? lower - x : (x > upper ? x - upper : 0);
  };
  return base::Norm({outside(object.lower_base_m[0], object.upper_base_m[0], p.x),
                     outside(object.lower_base_m[1], object.upper_base_m[1], p.y),
                     outside(object.lower_base_m[2], object.upper_base_m[2], p.z)});
}

template Vec3 Pseudonormal(const Surface&, std::uint32_t, Feature, int) noexcept;
template bool OnBorder(const Surface&, std::uint32_t, Feature, int) noexcept;

}  // namespace omni::haptics
