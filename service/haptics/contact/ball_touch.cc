#include "service/haptics/contact/ball_touch.h"

#include "service/haptics/contact/contact_slots.h"

namespace omni::haptics {
namespace {

ContactState* ContactOn(std::uint32_t object, State& state) noexcept {
  for (ContactState& contact : state.contacts) {
    if (contact.active && contact.object == object) return &contact;
  }
  return nullptr;
}

// The place that carries most stands for the contact; the ball's centre holds the tip.
void Hold(const BallContact& touched, const BallState& ball, const Vec3& tip, ContactState& contact) noexcept {
  std::size_t main = 0;
  for (std::size_t k = 1; k < static_cast<std::size_t>(touched.touch_count); ++k) {
    if (touched.touches[k].share > touched.touches[main].share) main = k;
  }
  contact.triangle = touched.touches[main].triangle;
  contact.proxy_m = touched.touches[main].at.point;
  contact.held_m = ball.centre_m;
  contact.depth_m = Norm(ball.centre_m - tip);
  contact.one_place = touched.touch_count == 1;
  contact.side = 1;
}

template <TreeView View>
bool IsNear(const View& view, const Target& target, double distance_m) noexcept {
  if (target.boxed && BoxDistance(target.object, target.tip) > distance_m) return false;
  return NearestInTree(view, target.root, target.tip, distance_m).triangle != kNoIndex;
}

// Gave way to the ball: nothing is felt until it is out again.
template <TreeView View>
bool IsStillIn(const View& view, const Target& target, double radius_m) noexcept {
  NearestResult nearest;
  return IsNear(view, target, radius_m) || (HasInside(target.object) && IsInside(view, target, target.tip, nearest));
}

// Rolls the ball of one contact, or of none yet, after the tip. False: nothing is touched any more.
template <TreeView View>
bool Roll(const View& view, const Target& target, const Touchables& touchables, const ContactState* known,
          ContactState& contact) noexcept {
  const double radius_m = touchables.tip_radius_m();
  Vec3 tip = known != nullptr ? touchables.TipOver(target, *known) : target.tip;
  BallState ball{known != nullptr ? known->held_m : target.from, target.from};
  if (known == nullptr && touchables.ChangedUnderTip(target.index)) {
    ball = StartBall(view, target.root, HasInside(target.object), radius_m, tip);
    StartSwap(contact);
  }
  BallContact touched = FollowBall(view, target.root, radius_m, tip, ball);
  if (touched.touch_count == 0 && tip != target.tip) {  // lifted out by what the body gave way a tick ago
    tip = target.tip;
    touched = FollowBall(view, target.root, radius_m, tip, ball);
  }
  if (touched.touch_count > 0) Hold(touched, ball, tip, contact);
  return touched.touch_count > 0;
}

template <TreeView View>
void UpdateBall(const View& view, const Target& target, const Touchables& touchables, double dt_s,
                State& state) noexcept {
  ContactState* known = ContactOn(target.index, state);
  const double radius_m = touchables.tip_radius_m();
  if (known == nullptr && target.boxed &&
      BoxDistance(target.object, target.tip) > radius_m + Norm(target.tip - target.from)) {
    return;
  }
  if (known != nullptr && known->popped) {
    if (!IsStillIn(view, target, radius_m)) *known = {};
    return;
  }
  ContactState contact;
  if (known != nullptr) contact = *known;
  contact.active = true;
  contact.object = target.index;
  if (!Roll(view, target, touchables, known, contact) || CameThrough(view, target, target.tip, dt_s, contact)) {
    if (known != nullptr) *known = {};
  } else if (known != nullptr) {
    *known = contact;
  } else {
    Keep(contact, state);
  }
}

}  // namespace

void StartBalls(const Touchables& touchables, State& state) noexcept {
  const double radius_m = touchables.tip_radius_m();
  const auto objects = touchables.scene().objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if ((objects[i].flags & kCollidable) == 0) continue;
    const Target target = touchables.TargetOf(i);
    if (target.boxed && BoxDistance(target.object, target.tip) > radius_m) continue;
    touchables.On(i, [&](const auto& view) noexcept {
      BallState ball = StartBall(view, target.root, HasInside(target.object), radius_m, target.tip);
      const BallContact touched = FollowBall(view, target.root, radius_m, target.tip, ball);
      if (touched.touch_count == 0) return;
      ContactState contact;
      contact.active = true;
      contact.object = i;
      Hold(touched, ball, target.tip, contact);
      Keep(contact, state);
    });
  }
}

void UpdateBalls(const Touchables& touchables, double dt_s, State& state) noexcept {
  const auto objects = touchables.scene().objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if ((objects[i].flags & kCollidable) == 0) continue;
    const Target target = touchables.TargetOf(i);
    touchables.On(i, [&](const auto& view) noexcept { UpdateBall(view, target, touchables, dt_s, state); });
  }
}

}  // namespace omni::haptics
