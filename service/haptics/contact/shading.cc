#include "service/haptics/contact/shading.h"

#include "service/haptics/contact/shading_walk.h"

namespace omni::haptics {

template Vec3 ShadedNormal(const Surface&, std::uint32_t, const std::array<double, 3>&) noexcept;
template Vec3 ShadedDirection(const Surface&, std::uint32_t, const ClosestPoint&, const Vec3&) noexcept;
template Vec3 ShadedDirection(const sculpt::SculptSurface&, std::uint32_t, const ClosestPoint&, const Vec3&) noexcept;

}  // namespace omni::haptics
