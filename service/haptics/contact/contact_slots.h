// Shared by all ways of finding contacts: their slots, and the predicates that decide on them.
#pragma once

#include "service/haptics/contact/contact_scene.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

inline constexpr double kSwapFade_s = 0.02;

// The proxy has been moved elsewhere: the force blends from the last one within kSwapFade_s.
inline void StartSwap(ContactState& contact) noexcept {
  contact.swapped_from_N = contact.last_force_N;
  contact.swap_left_s = kSwapFade_s;
}

// A tip that was pushed through a part is released when it is this far from its proxy, in the open, for this long.
inline constexpr double kThroughDepth_m = 0.010;
inline constexpr double kThroughTime_s = 0.1;

inline bool HasInside(const Object& object) noexcept {
  return (object.flags & kClosed) != 0 && (object.flags & kDoubleSided) == 0;
}

inline constexpr double kFarthestWall_m = 20;  // more than any scene is large

template <class Found>  // a ProxyPoint or a NearestResult
void Place(const Found& found, ContactState& contact) noexcept {
  contact.triangle = found.triangle;
  contact.proxy_m = contact.held_m = found.closest.point;
  contact.depth_m = std::sqrt(found.closest.distance_squared);
}

// Keeps a new contact in a free slot, else in that of the shallowest one if the new one is deeper.
inline bool KeepContact(const ContactState& contact, State& state) noexcept {
  ContactState* slot = &state.contacts[0];
  for (ContactState& c : state.contacts) {
    if (!c.active) {
      slot = &c;
      break;
    }
    if (c.depth_m < slot->depth_m) slot = &c;
  }
  if (slot->active && !(slot->depth_m < contact.depth_m)) return false;
  *slot = contact;
  return true;
}

// How the inside of an object is known.
inline Inside InsideOf(const Object& object) noexcept {
  if ((object.flags & kCracked) != 0) return Inside::kByWinding;
  if ((object.flags & kClosed) == 0) return Inside::kNone;
  if ((object.flags & kDoubleSided) != 0) return Inside::kNone;
  return object.component_count == 1 ? Inside::kBySign : Inside::kByWinding;
}

// Is the tip inside of the object? `nearest`: then a place of the surface that it is behind.
template <TreeView View>
bool IsInside(const View& view, const Target& target, const Vec3& tip, NearestResult& nearest) noexcept {
  const Inside inside = InsideOf(target.object);
  if (inside == Inside::kNone || (target.boxed && BoxDistance(target.object, tip) > 0)) return false;
  nearest = NearestInTree(view, target.root, tip);
  if (nearest.triangle == kNoIndex) return false;
  if (inside == Inside::kBySign) return SideOf(view, nearest, tip) < 0;
  if (!IsInsideByWinding(view, target.root, tip)) return false;
  // Of a part that the tip is not in, a wall may be nearer.
  if (SideOf(view, nearest, tip) > 0) {
    const NearestResult behind = NearestFaceInTree(view, target.root, tip, kFarthestWall_m, {});
    if (behind.triangle != kNoIndex) nearest = behind;
  }
  return true;
}

inline constexpr double kOppositeCosine = -0.6;  // a face that turns its back on the push: the far side of a thin part

// Held by a lip of micrometres at an edge, the tip of a ball may already be outside, in front of the face around the
// edge   (12.13).
template <TreeView View>
bool IsBeside(const View& view, const Target& target, const Vec3& tip, const ContactState& contact) noexcept {
  if (contact.one_place || (target.object.flags & kCracked) == 0) return false;
  const NearestResult nearest = NearestInTree(view, target.root, tip);
  if (nearest.triangle == kNoIndex || SideOf(view, nearest, tip) < 0) return false;
  const bool faces_away = Dot(FaceNormal(view, nearest.triangle), Normalized(contact.held_m - tip)) < kOppositeCosine;
  return !faces_away && !IsInsideByWinding(view, target.root, tip);
}

inline constexpr double kTrustedDepth_m = 0.002;  // deeper, a proxy that faces the wrong way around an edge is released

// A proxy stays on the face it entered through while the tip, deep inside, goes around a convex edge. If another face
// is nearer than half the proxy and the tip is behind that one too, the proxy should go there   (2.3). The far side of
// a thin part (facing the opposite way) does not count, nor does it hide a third face: the force stays on the side of
// entry.
template <TreeView View>
NearestResult NearerFace(const View& view, const Target& target, const Vec3& tip, std::uint32_t triangle,
                         const Vec3& proxy_m) noexcept {
  const double depth_m = Norm(proxy_m - tip);
  if (InsideOf(target.object) == Inside::kNone || !(depth_m > kTrustedDepth_m)) return {};
  const Vec3 outwards = (1 / depth_m) * (proxy_m - tip);
  const NearestResult nearest = NearestFaceInTree(view, target.root, tip, 0.5 * depth_m, {outwards, kOppositeCosine});
  if (nearest.triangle == kNoIndex || SideOf(view, nearest, tip) > 0) return {};
  const bool is_same = view.GetTriangle(nearest.triangle).component == view.GetTriangle(triangle).component;
  const bool may_go = (target.object.flags & kClosed) != 0 ? is_same : IsInsideByWinding(view, target.root, tip);
  return may_go ? nearest : NearestResult{};
}

// Pushed through a part and out on its far side, the pen would stay tied by a spring to where it went in.   (2.6)
template <TreeView View>
bool CameThrough(const View& view, const Target& target, const Vec3& tip, double dt_s, ContactState& contact) noexcept {
  NearestResult nearest;
  if (!(contact.depth_m > kThroughDepth_m) || IsInside(view, target, tip, nearest)) {
    contact.through_s = 0;
    return false;
  }
  contact.through_s += dt_s;
  return contact.through_s > kThroughTime_s;
}

}  // namespace omni::haptics
