// The tip as a ball: its proxy is the centre of a ball that stays outside of the surface, on the side it came from, and
// as near to the device point as it can get from where it is. docs/theory/haptics.md, section 12.
#pragma once

#include <array>
#include <type_traits>

#include "service/haptics/contact/half_spaces.h"
#include "service/haptics/geometry/query.h"
#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics {

inline constexpr double kMinBallRadius_m = 1e-6;  // smaller: use the point proxy
inline constexpr double kMaxBallRadius_m = 0.01;

// A ball of radius r rests at r from faces and at r (1 - kBallMargin) from edges and vertices, so that a face always
// comes before its own rim and inner edges have no effect, whatever the mesh. Nothing is ever nearer than r (1 - 2
// kBallMargin).
inline constexpr double kBallMargin = 1e-4;

// A point tip touches an object that is not closed as a ball of this radius whose skin lies in the surface: it has no
// need of sides or neighbours, and stays out of cracks   (12.12).
inline constexpr double kSkin_m = 6.5e-5;

inline constexpr int kMaxBallSteps = 32;      // straight moves in a tick; the ball goes on in the next
inline constexpr int kMaxBallQueries = 2048;  // triangles checked in a tick, after which no further move is begun
inline constexpr int kMaxBallNear = 512;      // triangles known in a move; more near by: the move gets shorter
inline constexpr int kMaxBallTouching = 16;   // surfaces touched at once; those that hold back most are kept

// Kept from tick to tick, one for each object a ball can touch. Frame: the mesh's rest frame. Code that moves the
// mesh's vertices must move the centre of a touching ball by the same motion, or keep the motion below the radius: the
// ball is pushed out of a surface that came up to its centre, not of one that passed it.
struct BallState {
  Vec3 centre_m;
  Vec3 device_point_m;  // of the last tick
};
static_assert(std::is_trivially_copyable_v<BallState>);

// One place at which the ball rests.
struct BallTouch {
  std::uint32_t triangle = kNoIndex;
  ClosestPoint at;   // place on the triangle: point, weights, feature
  Vec3 normal;       // unit, from the surface to the ball's centre
  double share = 0;  // >= 0: of the push centre - device point, share x |push| x normal is from here
};

struct BallContact {
  int touch_count = 0;  // 0: the centre is at the device point, and only then
  std::array<BallTouch, kMaxActive> touches;
  bool felt = false;    // something holds the centre off the device point; false: it is there, or on its way there
  bool settled = true;  // false: the ball is still under way, its place is free but not the nearest
};

// Of what the object has an inside, which is not free for a ball that starts: nothing, all behind the nearest point of
// its one closed surface   (1.3), all its winding number says is inside   (1.10).
enum class Inside : std::uint8_t { kNone, kBySign, kByWinding };

template <TreeView View>
bool IsInsideBy(Inside inside, const View& view, std::uint32_t root, const NearestResult& nearest,
                const Vec3& p) noexcept {
  if (inside == Inside::kNone) return false;
  return inside == Inside::kBySign ? SideOf(view, nearest, p) < 0 : IsInsideByWinding(view, root, p);
}

// Places the ball: at the device point if that is free, else outside near the nearest surface, from where the first
// tick lets it fall. Any device point with components within 1e6 m.
template <TreeView View>
BallState StartBall(const View& view, std::uint32_t root, Inside inside, double radius_m,
                    const Vec3& device_point_m) noexcept;

// One tick: the ball rolls and slides from state.centre_m to the local minimum of its distance to the device point. It
// passes through nothing at any speed, because its moves are swept. Precondition: kMinBallRadius_m <= radius_m <=
// kMaxBallRadius_m, the same as in the ticks before. A device point beyond 1e6 m, or no number, changes nothing.
//
// Work is bounded by the constants above. At the bounds the ball falls straight towards the device point, onto what is
// in its way, and goes on from there in the next tick, which has to be given its centre again; where more than
// kMaxBallNear triangles touch it at once it is held, and released when its device point is free and in sight of its
// centre   (12.6).
template <TreeView View>
BallContact FollowBall(const View& view, std::uint32_t root, double radius_m, const Vec3& device_point_m,
                       BallState& state) noexcept;

extern template BallState StartBall(const Surface&, std::uint32_t, Inside, double, const Vec3&) noexcept;
extern template BallContact FollowBall(const Surface&, std::uint32_t, double, const Vec3&, BallState&) noexcept;
extern template BallState StartBall(const sculpt::SculptSurface&, std::uint32_t, Inside, double, const Vec3&) noexcept;
extern template BallContact FollowBall(const sculpt::SculptSurface&, std::uint32_t, double, const Vec3&,
                                       BallState&) noexcept;

}  // namespace omni::haptics
