#include "service/haptics/geometry/topology.h"

namespace omni::haptics {

template Vec3 Pseudonormal(const Surface&, std::uint32_t, Feature, int) noexcept;
template bool OnBorder(const Surface&, std::uint32_t, Feature, int) noexcept;

}  // namespace omni::haptics
