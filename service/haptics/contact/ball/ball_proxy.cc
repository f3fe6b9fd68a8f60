#include "service/haptics/contact/ball/ball_proxy.h"

#include "service/haptics/contact/ball/ball_in_tree.h"

namespace omni::haptics {

template BallState StartBall(const Surface&, std::uint32_t, bool, double, const Vec3&) noexcept;
template BallContact FollowBall(const Surface&, std::uint32_t, double, const Vec3&, BallState&) noexcept;
template BallState StartBall(const sculpt::SculptSurface&, std::uint32_t, bool, double, const Vec3&) noexcept;
template BallContact FollowBall(const sculpt::SculptSurface&, std::uint32_t, double, const Vec3&, BallState&) noexcept;

}  // namespace omni::haptics
