#include "service/haptics/contact/contact_slots.h"
#include "service/haptics/contact/contacts.h"
#include "service/haptics/contact/proxy.h"
#include "service/haptics/geometry/query.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

constexpr double kBackDate_m =
    1e-6;                       // start of a swept segment, so that a hit lost to rounding is found in the next tick
constexpr int kMaxEntries = 4;  // surfaces that one segment may enter and leave again
constexpr int kMaxSkip = 2 * kMaxContacts;

// Components of one object that a sweep must not enter: those in contact, and those just left.
struct SkipList {
  std::array<std::uint32_t, kMaxSkip> components{};
  int count = 0;
  void Add(std::uint32_t component) noexcept {
    if (count < kMaxSkip) components[static_cast<std::size_t>(count++)] = component;
  }
};

// Contacts released in this tick.
struct Left {
  std::array<std::uint32_t, kMaxContacts> object{};
  std::array<std::uint32_t, kMaxContacts> component{};
  std::size_t count = 0;
};

template <TreeView View>
SkipList InContact(const View& view, std::uint32_t object, const State& state, const ContactState* except) noexcept {
  SkipList skip;
  for (const ContactState& c : state.contacts) {
    if (c.active && &c != except && c.object == object) skip.Add(view.GetTriangle(c.triangle).component);
  }
  return skip;
}

template <TreeView View>
CrossingResult Crossing(const View& view, const Target& target, const Vec3& start, const Vec3& end,
                        const SkipList& skip) noexcept {
  const bool double_sided = (target.object.flags & kDoubleSided) != 0;
  return CrossingInTree(view, target.root, start, end, double_sided, {skip.components.data(), skip.count});
}

// A face that is cut into coplanar triangles: there the descent sees nothing but its own plane.
template <MeshView View>
bool IsFlatAround(const View& view, std::uint32_t triangle) noexcept {
  constexpr double kFlatCosine = 1 - 1e-9;
  const Vec3 normal = FaceNormal(view, triangle);
  for (const std::uint32_t other : view.GetTriangle(triangle).neighbour) {
    if (other != kNoIndex && Dot(FaceNormal(view, other), normal) > kFlatCosine) return true;
  }
  return false;
}

// Local descent, and from within a plane to the nearest face of the same smooth surface, so that a finely cut plane
// behaves as a coarse one   (2.1).
template <TreeView View>
ProxyPoint DescendOn(const View& view, const Target& target, std::uint32_t start, const Vec3& tip) noexcept {
  const ProxyPoint proxy = DescendOnSurface(view, start, tip);
  if (proxy.closest.feature != Feature::kFace || !HasInside(target.object) || !IsFlatAround(view, proxy.triangle))
    return proxy;
  const double depth_m = std::sqrt(proxy.closest.distance_squared);
  const NearestResult nearest = NearestFaceInTree(view, target.root, tip, depth_m * (1 - 1e-9),
                                                  {FaceNormal(view, proxy.triangle), kSmoothCosine});
  if (nearest.triangle == kNoIndex) return proxy;
  if (view.GetTriangle(nearest.triangle).component != view.GetTriangle(proxy.triangle).component) return proxy;
  return DescendOnSurface(view, nearest.triangle, tip);
}

bool Skips(const SkipList& skip, std::uint32_t component) noexcept {
  const auto* const end = skip.components.data() + skip.count;
  return std::find(skip.components.data(), end, component) != end;
}

// Within a micrometre of a concave edge a tip can be in front of one wall and behind the other with no crossing between
// the segment's start and the tip. Where a contact ends or an entry leads nowhere, the exact sign decides.
template <TreeView View>
bool AcquireInside(const View& view, const Target& target, const Vec3& tip, const SkipList& skip,
                   ContactState& contact) noexcept {
  NearestResult nearest;
  if (!IsInside(view, target, tip, nearest)) return false;
  if (Skips(skip, view.GetTriangle(nearest.triangle).component)) return false;
  contact.side = 1;
  Place(nearest, contact);
  return true;
}

// Follows the segment from outside to the tip. True if it ends behind a surface: `contact` then has its proxy, and its
// anchor where the surface was entered unless it had one.
template <TreeView View>
bool Acquire(const View& view, const Target& target, Vec3 start, const Vec3& tip, const SkipList& skip, bool was_inside,
             ContactState& contact) noexcept {
  for (int entry = 0; entry < kMaxEntries; ++entry) {
    const CrossingResult hit = Crossing(view, target, start, tip, skip);
    if (hit.triangle == kNoIndex) {
      return (was_inside || entry > 0) && AcquireInside(view, target, tip, skip, contact);
    }
    contact.side = hit.front ? 1 : -1;
    const ProxyPoint proxy = DescendOn(view, target, hit.triangle, tip);
    Place(proxy, contact);
    if (ClassifyProxy(view, proxy, tip, contact.side) == ProxyVerdict::kInside) {
      if (contact.anchor_triangle == kNoIndex) {
        const ClosestPoint at = ClosestOnTriangle(view.TriangleCorners(hit.triangle), start + hit.t * (tip - start));
        contact.anchor_triangle = hit.triangle;
        contact.anchor_weights = at.weights;
        contact.sticking = true;
      }
      return true;
    }
    start = proxy.closest.point + (kBackDate_m * contact.side) * NormalAt(view, proxy);
  }
  return AcquireInside(view, target, tip, skip, contact);
}

template <TreeView View>
void ReleaseFromCrease(const View& view, const Target& target, const Vec3& tip, const ProxyPoint& proxy,
                       ContactState& contact) noexcept {
  const NearestResult nearer = NearerFace(view, target, tip, proxy.triangle, proxy.closest.point);
  if (nearer.triangle == kNoIndex) return;
  Place(nearer, contact);
  contact.anchor_triangle = kNoIndex;
  StartSwap(contact);
}

template <TreeView View>
void Follow(const View& view, const Target& target, const ContactScene& contact_scene, double dt_s, State& state,
            ContactState& contact, Left& left) noexcept {
  Vec3 tip = contact_scene.TipOver(target, contact);
  ProxyPoint proxy = DescendOn(view, target, contact.triangle, tip);
  if (contact.popped) {
    NearestResult nearest;
    if (IsInside(view, target, tip, nearest)) {
      Place(proxy, contact);
    } else {
      contact = {};
    }
    return;
  }
  // A soft body's displacement of a tick ago may lift the tip out although it is still inside: then the tip itself
  // counts.
  if (tip != target.tip && ClassifyProxy(view, proxy, tip, contact.side) != ProxyVerdict::kInside) {
    tip = target.tip;
    proxy = DescendOn(view, target, contact.triangle, tip);
  }
  Place(proxy, contact);
  if (CameThrough(view, target, tip, dt_s, contact)) {
    contact = {};
    return;
  }
  if (ClassifyProxy(view, proxy, tip, contact.side) == ProxyVerdict::kInside) {
    ReleaseFromCrease(view, target, tip, proxy, contact);
    return;
  }
  // Out here, but perhaps straight into another part of the same object: the proxy is outside, so sweep from there.
  const std::uint32_t component = view.GetTriangle(proxy.triangle).component;
  const Vec3 start = proxy.closest.point + (kBackDate_m * contact.side) * NormalAt(view, proxy);
  if (Acquire(view, target, start, tip, InContact(view, contact.object, state, &contact), true, contact)) return;
  left.object[left.count] = contact.object;
  left.component[left.count++] = component;
  contact = {};
}

template <TreeView View>
bool TakeOn(const View& view, const Target& target, const Vec3& start, const SkipList& skip, State& state) noexcept {
  ContactState contact;
  contact.active = true;
  contact.object = target.index;
  return Acquire(view, target, start, target.tip, skip, false, contact) && KeepContact(contact, state);
}

// An object was put around the tip, or its surface moved over it: contact starts where the tip is, and the force fades
// in.
template <TreeView View>
void TakeOnInside(const View& view, const Target& target, State& state) noexcept {
  ContactState contact;
  contact.active = true;
  contact.object = target.index;
  StartSwap(contact);
  if (AcquireInside(view, target, target.tip, InContact(view, target.index, state, nullptr), contact)) {
    KeepContact(contact, state);
  }
}

// Swept segment of the tip against one object. A one-sided object is entered from the front only, so the segment may be
// back-dated; at a double-sided one that would find the side just left.
template <TreeView View>
void Sweep(const View& view, const Target& target, const Left& left, State& state) noexcept {
  const bool double_sided = (target.object.flags & kDoubleSided) != 0;
  for (int taken = 0; taken < kMaxContacts; ++taken) {
    SkipList skip = InContact(view, target.index, state, nullptr);
    if (skip.count >= static_cast<int>(target.object.component_count)) return;
    for (std::size_t k = 0; double_sided && k < left.count; ++k) {
      if (left.object[k] == target.index) skip.Add(left.component[k]);
    }
    // Without back-dating first: near a concave edge a back-dated start may lie behind the other wall and would enter
    // nothing.
    if (TakeOn(view, target, target.from, skip, state)) continue;
    if (double_sided) return;
    const Vec3 start = target.from - kBackDate_m * Normalized(target.tip - target.from);
    if (!TakeOn(view, target, start, skip, state)) return;
  }
}

// A face that moved since the last tick may have swept over the tip: sweep the tip in the face's frame.
void SweepMovedRegions(const ContactScene& contact_scene, State& state) noexcept {
  const auto regions = contact_scene.scene().regions();
  const Surface& surface = contact_scene.surface();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const double moved_m = state.regions[r].offset_m - state.regions[r].last_offset_m;
    if (moved_m == 0) continue;
    const Target target = contact_scene.TargetOf(regions[r].object);
    const SkipList skip = InContact(surface, target.index, state, nullptr);
    if ((target.object.flags & kCollidable) == 0) continue;
    if (skip.count >= static_cast<int>(target.object.component_count)) continue;
    const Vec3 start = target.from + moved_m * regions[r].normal;
    const CrossingResult hit = Crossing(surface, target, start, target.tip, skip);
    if (hit.triangle == kNoIndex || surface.RegionOf(hit.triangle) != r) continue;
    TakeOn(surface, target, start, skip, state);
  }
}

}  // namespace

void StartContacts(const ContactScene& contact_scene, State& state) noexcept {
  StartBalls(contact_scene, state);
  const auto objects = contact_scene.scene().objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if ((objects[i].flags & kCollidable) == 0 || contact_scene.TipAt(i).radius_m > 0) continue;
    const Target target = contact_scene.TargetOf(i);
    contact_scene.VisitSurface(i, [&](const auto& view) noexcept {
      ContactState contact;
      contact.active = true;
      contact.object = i;
      if (!AcquireInside(view, target, target.tip, {}, contact)) return;
      contact.popped = state.appears;
      KeepContact(contact, state);
    });
  }
}

void UpdateContacts(const ContactScene& contact_scene, double dt_s, State& state) noexcept {
  UpdateBalls(contact_scene, dt_s, state);
  Left left;
  for (ContactState& contact : state.contacts) {
    if (!contact.active || contact_scene.TipAt(contact.object).radius_m > 0) continue;
    const Target target = contact_scene.TargetOf(contact.object);
    contact_scene.VisitSurface(contact.object, [&](const auto& view) noexcept {
      Follow(view, target, contact_scene, dt_s, state, contact, left);
    });
  }
  const auto objects = contact_scene.scene().objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if ((objects[i].flags & kCollidable) == 0 || contact_scene.TipAt(i).radius_m > 0) continue;
    const Target target = contact_scene.TargetOf(i);
    contact_scene.VisitSurface(i, [&](const auto& view) noexcept {
      if (contact_scene.ChangedUnderTip(i)) {
        TakeOnInside(view, target, state);
      } else {
        Sweep(view, target, left, state);
      }
    });
  }
  SweepMovedRegions(contact_scene, state);
}

template ProxyPoint DescendOnSurface(const Surface&, std::uint32_t, const Vec3&) noexcept;
template ProxyVerdict ClassifyProxy(const Surface&, const ProxyPoint&, const Vec3&, double) noexcept;

}  // namespace omni::haptics
