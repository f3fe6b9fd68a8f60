#include "service/haptics/contact/proxy.h"

namespace omni::haptics {

template ProxyPoint Descend(const Surface&, std::uint32_t, const Vec3&) noexcept;
template ProxyVerdict Judge(const Surface&, const ProxyPoint&, const Vec3&, double) noexcept;

}  // namespace omni::haptics
