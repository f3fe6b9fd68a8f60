#include "service/haptics/contact/contact_set.h"

#include "service/haptics/geometry/query.h"

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

// What was let go in this tick.
struct Left {
  std::array<std::uint32_t, kMaxContacts> object{};
  std::array<std::uint32_t, kMaxContacts> component{};
  std::size_t count = 0;
};

SkipList InContact(const Surface& surface, std::uint32_t object, const State& state,
                   const ContactState* except) noexcept {
  SkipList skip;
  for (const ContactState& c : state.contacts) {
    if (c.active && &c != except && c.object == object) skip.Add(surface.GetTriangle(c.triangle).component);
  }
  return skip;
}

double Depth(const ContactState& contact, const Vec3& tip) noexcept { return Norm(contact.proxy_base_m - tip); }

void Place(const ProxyPoint& proxy, ContactState& contact) noexcept {
  contact.triangle = proxy.triangle;
  contact.proxy_base_m = proxy.closest.point;
}

// Inside by the sign at the nearest point of the whole object; exact for closed objects.
bool IsInside(const Surface& surface, const Object& object, const Vec3& tip, NearestResult& nearest) noexcept {
  if (BoxDistance(object, tip) > 0) return false;
  nearest = NearestPoint(surface, object, tip);
  return nearest.triangle != kNoIndex && SideOf(surface, nearest, tip) < 0;
}

bool HasInside(const Object& object) noexcept {
  return (object.flags & kClosed) != 0 && (object.flags & kDoubleSided) == 0;
}

// A face that is cut into coplanar triangles: there the descent sees nothing but its own plane.
bool IsFlatAround(const Surface& surface, std::uint32_t triangle) noexcept {
  constexpr double kFlatCosine = 1 - 1e-9;
  const Vec3 normal = FaceNormal(surface, triangle);
  for (const std::uint32_t other : surface.GetTriangle(triangle).neighbour) {
    if (other != kNoIndex && Dot(FaceNormal(surface, other), normal) > kFlatCosine) return true;
  }
  return false;
}

// Local descent, and from within a plane to the nearest face of the same smooth surface, so that a plane in many
// triangles does as one in few   (2.1).
ProxyPoint DescendOn(const Surface& surface, const Object& object, std::uint32_t start, const Vec3& tip) noexcept {
  const ProxyPoint proxy = Descend(surface, start, tip);
  if (proxy.closest.feature != Feature::kFace || !HasInside(object) || !IsFlatAround(surface, proxy.triangle))
    return proxy;
  const double depth_m = std::sqrt(proxy.closest.distance_squared);
  const NearestResult nearest = NearestFaceInTree(surface, object.root, tip, depth_m * (1 - 1e-9),
                                                  {FaceNormal(surface, proxy.triangle), kSmoothCosine});
  if (nearest.triangle == kNoIndex) return proxy;
  if (surface.GetTriangle(nearest.triangle).component != surface.GetTriangle(proxy.triangle).component) return proxy;
  return Descend(surface, nearest.triangle, tip);
}

bool Skips(const SkipList& skip, std::uint32_t component) noexcept {
  const auto* const end = skip.components.data() + skip.count;
  return std::find(skip.components.data(), end, component) != end;
}

// Within a micrometre of a concave edge a tip can be in front of one wall and behind the other with no crossing between
// where it is looked from and where it is. Where a contact ends or an entry leads nowhere, the exact sign has the last
// word.
bool AcquireInside(const Surface& surface, const Object& object, const Vec3& tip, const SkipList& skip,
                   ContactState& contact) noexcept {
  NearestResult nearest;
  if (!HasInside(object) || !IsInside(surface, object, tip, nearest)) return false;
  if (Skips(skip, surface.GetTriangle(nearest.triangle).component)) return false;
  contact.side = 1;
  contact.triangle = nearest.triangle;
  contact.proxy_base_m = nearest.closest.point;
  return true;
}

// Follows the segment from outside to the tip. True if it ends behind a surface: `contact` then has its proxy, and its
// anchor where the surface was entered unless it had one.
bool Acquire(const Surface& surface, const Object& object, Vec3 start, const Vec3& tip, const SkipList& skip,
             bool was_inside, ContactState& contact) noexcept {
  for (int entry = 0; entry < kMaxEntries; ++entry) {
    const CrossingResult hit = FirstCrossing(surface, object, start, tip, skip.components.data(), skip.count);
    if (hit.triangle == kNoIndex) {
      return (was_inside || entry > 0) && AcquireInside(surface, object, tip, skip, contact);
    }
    contact.side = hit.front ? 1 : -1;
    const ProxyPoint proxy = DescendOn(surface, object, hit.triangle, tip);
    Place(proxy, contact);
    if (Judge(surface, proxy, tip, contact.side) == ProxyVerdict::kInside) {
      if (contact.anchor_triangle == kNoIndex) {
        const ClosestPoint at = ClosestOnTriangle(surface.TriangleCorners(hit.triangle), start + hit.t * (tip - start));
        contact.anchor_triangle = hit.triangle;
        contact.anchor_weights = at.weights;
        contact.sticking = true;
      }
      return true;
    }
    start = proxy.closest.point + (kBackDate_m * contact.side) * NormalAt(surface, proxy);
  }
  return AcquireInside(surface, object, tip, skip, contact);
}

// A proxy stays on the face it entered through while the tip, deep inside, goes around a convex edge. If another face
// is nearer than half the proxy and the tip is behind that one too, the proxy goes there   (2.3). The far side of a
// thin part (facing the opposite way) does not count, nor does it hide a third face: entered from here, felt from here.
void ReleaseFromCrease(const Surface& surface, const Object& object, const Vec3& tip, const ProxyPoint& proxy,
                       ContactState& contact) noexcept {
  constexpr double kOppositeCosine = -0.6;
  const double depth_m = std::sqrt(proxy.closest.distance_squared);
  if (!HasInside(object) || !(depth_m > kTrustedDepth_m)) return;
  const Vec3 outwards = (1 / depth_m) * (proxy.closest.point - tip);
  const NearestResult nearest =
      NearestFaceInTree(surface, object.root, tip, 0.5 * depth_m, {outwards, kOppositeCosine});
  if (nearest.triangle == kNoIndex || SideOf(surface, nearest, tip) > 0) return;
  if (surface.GetTriangle(nearest.triangle).component != surface.GetTriangle(proxy.triangle).component) return;
  contact.triangle = nearest.triangle;
  contact.proxy_base_m = nearest.closest.point;
  contact.anchor_triangle = kNoIndex;
  contact.swap_left_s = kSwapFade_s;
}

// Pushed through a part and out on its far side, the pen would hang on a spring to where it went in.   (2.6)
bool CameThrough(const Surface& surface, const Object& object, const Vec3& tip, double depth_m, double dt_s,
                 ContactState& contact) noexcept {
  NearestResult nearest;
  if (!(depth_m > kThroughDepth_m) || (HasInside(object) && IsInside(surface, object, tip, nearest))) {
    contact.through_s = 0;
    return false;
  }
  contact.through_s += dt_s;
  return contact.through_s > kThroughTime_s;
}

void Follow(const Scene& scene, const Surface& surface, const Vec3& tip, double dt_s, State& state,
            ContactState& contact, Left& left) noexcept {
  const Object& object = scene.objects()[contact.object];
  const ProxyPoint proxy = DescendOn(surface, object, contact.triangle, tip);
  if (contact.popped) {
    NearestResult nearest;
    if (IsInside(surface, object, tip, nearest)) {
      Place(proxy, contact);
    } else {
      contact = {};
    }
    return;
  }
  Place(proxy, contact);
  if (CameThrough(surface, object, tip, Depth(contact, tip), dt_s, contact)) {
    contact = {};
    return;
  }
  if (Judge(surface, proxy, tip, contact.side) == ProxyVerdict::kInside) {
    ReleaseFromCrease(surface, object, tip, proxy, contact);
    return;
  }
  // Out here, but perhaps straight into another part of the same object: the proxy is outside, look from there.
  const std::uint32_t component = surface.GetTriangle(proxy.triangle).component;
  const Vec3 start = proxy.closest.point + (kBackDate_m * contact.side) * NormalAt(surface, proxy);
  if (Acquire(surface, object, start, tip, InContact(surface, contact.object, state, &contact), true, contact)) return;
  left.object[left.count] = contact.object;
  left.component[left.count++] = component;
  contact = {};
}

// A free slot, else that of the shallowest contact if the new one is deeper, else none.
ContactState* SlotFor(double depth_m, const Vec3& tip, State& state) noexcept {
  ContactState* shallowest = &state.contacts[0];
  for (ContactState& c : state.contacts) {
    if (!c.active) return &c;
    if (Depth(c, tip) < Depth(*shallowest, tip)) shallowest = &c;
  }
  return Depth(*shallowest, tip) < depth_m ? shallowest : nullptr;
}

bool TakeOn(const Surface& surface, const Object& object, std::uint32_t index, const Vec3& start, const Vec3& tip,
            const SkipList& skip, State& state) noexcept {
  ContactState contact;
  contact.active = true;
  contact.object = index;
  if (!Acquire(surface, object, start, tip, skip, false, contact)) return false;
  ContactState* slot = SlotFor(Depth(contact, tip), tip, state);
  if (slot != nullptr) *slot = contact;
  return slot != nullptr;
}

// Swept segment of the tip against one object. A one-sided object is entered from the front only, so the segment may be
// back-dated; at a double-sided one that would find the side just left.
void Sweep(const Surface& surface, const Object& object, std::uint32_t index, const Vec3& tip, const Left& left,
           State& state) noexcept {
  const bool double_sided = (object.flags & kDoubleSided) != 0;
  for (int taken = 0; taken < kMaxContacts; ++taken) {
    SkipList skip = InContact(surface, index, state, nullptr);
    if (skip.count >= static_cast<int>(object.component_count)) return;
    for (std::size_t k = 0; double_sided && k < left.count; ++k) {
      if (left.object[k] == index) skip.Add(left.component[k]);
    }
    // As it is first: near a concave edge the start dated back may lie behind the other wall, and would enter nothing.
    const Vec3 from = state.last_device_point_base_m;
    if (TakeOn(surface, object, index, from, tip, skip, state)) continue;
    if (double_sided) return;
    const Vec3 start = from - kBackDate_m * Normalized(tip - from);
    if (!TakeOn(surface, object, index, start, tip, skip, state)) return;
  }
}

// A face that moved since the last tick may have swept over the tip: look at the tip's motion in the face's frame.
void SweepMovedRegions(const Scene& scene, const Surface& surface, const Vec3& tip, State& state) noexcept {
  const auto regions = scene.regions();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const double moved_m = state.regions[r].offset_m - state.regions[r].last_offset_m;
    if (moved_m == 0) continue;
    const Object& object = scene.objects()[regions[r].object];
    const SkipList skip = InContact(surface, regions[r].object, state, nullptr);
    if ((object.flags & kCollidable) == 0 || skip.count >= static_cast<int>(object.component_count)) continue;
    const Vec3 start = state.last_device_point_base_m + moved_m * regions[r].normal;
    const CrossingResult hit = FirstCrossing(surface, object, start, tip, skip.components.data(), skip.count);
    if (hit.triangle == kNoIndex || surface.RegionOf(hit.triangle) != r) continue;
    TakeOn(surface, object, regions[r].object, start, tip, skip, state);
  }
}

}  // namespace

void StartContacts(const Scene& scene, const Surface& surface, const Vec3& tip, State& state) noexcept {
  const auto objects = scene.objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if ((objects[i].flags & kCollidable) == 0 || !HasInside(objects[i])) continue;
    NearestResult nearest;
    if (!IsInside(surface, objects[i], tip, nearest)) continue;
    ContactState contact;
    contact.active = true;
    contact.object = i;
    contact.triangle = nearest.triangle;
    contact.proxy_base_m = nearest.closest.point;
    ContactState* slot = SlotFor(Depth(contact, tip), tip, state);
    if (slot != nullptr) *slot = contact;
  }
}

void UpdateContacts(const Scene& scene, const Surface& surface, const Vec3& tip, double dt_s, State& state) noexcept {
  Left left;
  for (ContactState& contact : state.contacts) {
    if (contact.active) Follow(scene, surface, tip, dt_s, state, contact, left);
  }
  const auto objects = scene.objects();
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    if ((objects[i].flags & kCollidable) != 0) Sweep(surface, objects[i], i, tip, left, state);
  }
  SweepMovedRegions(scene, surface, tip, state);
}

}  // namespace omni::haptics
