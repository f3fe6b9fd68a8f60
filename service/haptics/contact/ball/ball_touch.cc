#include "service/haptics/contact/ball/ball_in_tree.h"
#include "service/haptics/contact/ball/ball_proxy.h"
#include "service/haptics/contact/contact_slots.h"
#include "service/haptics/contact/contacts.h"
#include "service/haptics/geometry/topology.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

using TipShape = ContactScene::TipShape;

ContactState* ContactOn(std::uint32_t object, State& state) noexcept {
  for (ContactState& contact : state.contacts) {
    if (contact.active && contact.object == object) return &contact;
  }
  return nullptr;
}

ContactState NewContact(std::uint32_t object) noexcept {
  ContactState contact;
  contact.active = true;
  contact.object = object;
  return contact;
}

// The place that carries most stands for the contact; the ball's centre holds the tip. Within the skin the tip is over
// the surface: nothing is felt, and what was felt before is forgotten.
void Hold(const BallContact& touched, const BallState& ball, const Vec3& tip, double skin_m,
          ContactState& contact) noexcept {
  const double height_m = skin_m - Norm(ball.centre_m - tip);
  if (skin_m > 0 && height_m >= 0) contact = NewContact(contact.object);
  std::size_t main = 0;
  for (std::size_t k = 1; k < static_cast<std::size_t>(touched.touch_count); ++k) {
    if (touched.touches[k].share > touched.touches[main].share) main = k;
  }
  contact.triangle = touched.touches[main].triangle;
  contact.proxy_m = touched.touches[main].at.point;
  contact.held_m = ball.centre_m;
  contact.depth_m = std::max(0.0, -height_m);
  contact.one_place = touched.touch_count == 1;
  contact.in_flight = !touched.felt || (skin_m > 0 && height_m >= 0);
  contact.side = 1;
}

std::uint64_t TouchedObjects(const State& state) noexcept {
  std::uint64_t objects = 0;
  for (const ContactState& contact : state.contacts) {
    if (contact.active) objects |= std::uint64_t{1} << contact.object;
  }
  return objects;
}

// Where there are more contacts than slots, the ball of the one that is left out is lost.
void KeepBall(const ContactState& contact, State& state) noexcept {
  const std::uint64_t known = TouchedObjects(state) | std::uint64_t{1} << contact.object;
  KeepContact(contact, state);
  state.ball_restarts |= known & ~TouchedObjects(state);
}

template <TreeView View>
bool IsNear(const View& view, const Target& target, double distance_m) noexcept {
  if (target.boxed && BoxDistance(target.object, target.tip) > distance_m) return false;
  return NearestInTree(view, target.root, target.tip, distance_m).triangle != kNoIndex;
}

// The ball popped through: no force until it is out again.
template <TreeView View>
bool IsStillIn(const View& view, const Target& target, double radius_m) noexcept {
  NearestResult nearest;
  return IsNear(view, target, radius_m) || IsInside(view, target, target.tip, nearest);
}

// Rolls the ball from `centre` after the tip; `tip` is the tip over the surface as a soft body carries it. False: it is
// at the tip, where it touches nothing.
template <TreeView View>
bool RollBall(const View& view, const Target& target, const TipShape& shape, const Vec3& centre, Vec3 tip,
              ContactState& contact) noexcept {
  BallState ball{centre, target.from};
  BallContact touched = FollowBall(view, target.root, shape.radius_m, tip, ball);
  const bool lifted = !touched.felt || Norm(ball.centre_m - tip) <= shape.skin_m;
  if (lifted && tip != target.tip) {  // out, by the body's displacement of a tick ago
    tip = target.tip;
    touched = FollowBall(view, target.root, shape.radius_m, tip, ball);
  }
  if (touched.touch_count > 0) Hold(touched, ball, tip, shape.skin_m, contact);
  return touched.touch_count > 0;
}

// The same from a free place near `place`, which may be inside.
template <TreeView View>
bool RestartBall(const View& view, const Target& target, const TipShape& shape, const Vec3& place,
                 ContactState& contact) noexcept {
  const BallState ball = StartBall(view, target.root, InsideOf(target.object), shape.radius_m, place);
  return RollBall(view, target, shape, ball.centre_m, target.tip, contact);
}

// To a nearer face around a convex edge   (2.3), if the ball has room in front of it.
template <TreeView View>
void LeaveCrease(const View& view, const Target& target, const TipShape& shape, const Vec3& tip,
                 ContactState& contact) noexcept {
  const double radius_m = shape.radius_m;
  const NearestResult face = NearerFace(view, target, tip, contact.triangle, contact.proxy_m);
  if (face.triangle == kNoIndex) return;
  const Vec3 centre = face.closest.point + radius_m * FaceNormal(view, face.triangle);
  if (NearestInTree(view, target.root, centre, radius_m * (1 - kBallMargin)).triangle != kNoIndex) return;
  const bool cracked = (target.object.flags & kCracked) != 0;
  if (cracked && IsInsideByWinding(view, target.root, centre)) return;  // that wall lies in another part
  contact.anchor_triangle = kNoIndex;
  StartSwap(contact);
  RollBall(view, target, shape, centre, tip, contact);
}

// A surface that moved may have passed the ball: then the ball restarts outside, and its force fades in.
template <TreeView View>
bool FollowTip(const View& view, const Target& target, const ContactScene& contact_scene, const ContactState* known,
               bool restarts, double dt_s, ContactState& contact) noexcept {
  const TipShape shape = contact_scene.TipAt(target.index);
  const Vec3 last = known != nullptr ? known->held_m : restarts ? target.tip : target.from;
  bool starts = restarts && known == nullptr;
  if (!starts && (restarts || contact_scene.FaceMoved(target.index))) {
    NearestResult nearest;
    starts = IsInside(view, target, last, nearest);
  }
  if (starts) {
    StartSwap(contact);
    return RestartBall(view, target, shape, last, contact);
  }
  const Vec3 tip = known != nullptr ? contact_scene.TipOver(target, *known) : target.tip;
  if (!RollBall(view, target, shape, last, tip, contact)) return false;
  if (CameThrough(view, target, target.tip, dt_s, contact)) {
    contact = NewContact(target.index);
    return RestartBall(view, target, shape, target.tip, contact);
  }
  if (shape.skin_m > 0 && contact.IsFelt() && IsBeside(view, target, tip, contact)) {
    StartSwap(contact);
    return RestartBall(view, target, shape, target.tip, contact);
  }
  if (contact.IsFelt()) LeaveCrease(view, target, shape, tip, contact);
  return true;
}

template <TreeView View>
void UpdateBall(const View& view, const Target& target, const ContactScene& contact_scene, double dt_s,
                State& state) noexcept {
  const std::uint64_t bit = std::uint64_t{1} << target.index;
  const bool restarts = contact_scene.ChangedUnderTip(target.index) || (state.ball_restarts & bit) != 0;
  state.ball_restarts &= ~bit;
  ContactState* known = ContactOn(target.index, state);
  const double radius_m = contact_scene.TipAt(target.index).radius_m;
  if (known == nullptr && target.boxed &&
      BoxDistance(target.object, target.tip) > radius_m + Norm(target.tip - target.from)) {
    return;
  }
  if (known != nullptr && known->popped) {
    if (!IsStillIn(view, target, radius_m)) *known = {};
    return;
  }
  ContactState contact = known != nullptr ? *known : NewContact(target.index);
  const bool touches = FollowTip(view, target, contact_scene, known, restarts, dt_s, contact);
  if (known != nullptr) {
    *known = touches ? contact : ContactState{};
  } else if (touches) {
    KeepBall(contact, state);
  }
}

}  // namespace

void StartBalls(const ContactScene& contact_scene, State& state) noexcept {
  state.ball_restarts = 0;
  const auto objects = contact_scene.scene().objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    const TipShape shape = contact_scene.TipAt(i);
    if ((objects[i].flags & kCollidable) == 0 || shape.radius_m == 0) continue;
    const Target target = contact_scene.TargetOf(i);
    if (target.boxed && BoxDistance(target.object, target.tip) > shape.radius_m) continue;
    contact_scene.VisitSurface(i, [&](const auto& view) noexcept {
      ContactState contact = NewContact(i);
      if (!RestartBall(view, target, shape, target.tip, contact)) return;
      contact.popped = state.appears;
      KeepBall(contact, state);
    });
  }
}

void UpdateBalls(const ContactScene& contact_scene, double dt_s, State& state) noexcept {
  const auto objects = contact_scene.scene().objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if ((objects[i].flags & kCollidable) == 0 || contact_scene.TipAt(i).radius_m == 0) continue;
    const Target target = contact_scene.TargetOf(i);
    contact_scene.VisitSurface(
        i, [&](const auto& view) noexcept { UpdateBall(view, target, contact_scene, dt_s, state); });
  }
}

template BallState StartBall(const Surface&, std::uint32_t, Inside, double, const Vec3&) noexcept;
template BallContact FollowBall(const Surface&, std::uint32_t, double, const Vec3&, BallState&) noexcept;
template BallState StartBall(const sculpt::SculptSurface&, std::uint32_t, Inside, double, const Vec3&) noexcept;
template BallContact FollowBall(const sculpt::SculptSurface&, std::uint32_t, double, const Vec3&, BallState&) noexcept;

}  // namespace omni::haptics
