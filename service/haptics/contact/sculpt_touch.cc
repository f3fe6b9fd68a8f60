#include "service/haptics/contact/contacts.h"

#include "service/haptics/contact/contact_slots.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/sculpt_query.h"
#include "service/haptics/stability/stability.h"

namespace omni::haptics {
namespace {

constexpr double kReach_m = 0.01;  // how far a place of the surface may have moved and still be the same place

void PutAnchor(const sculpt::SculptSurface& surface, ContactState& contact) noexcept {
  sculpt::KeptFeature anchor{contact.anchor_triangle, contact.anchor_weights, contact.anchor_m, contact.normal};
  sculpt::RebindFeature(surface, kReach_m, anchor);
  contact.anchor_triangle = anchor.triangle;
  contact.anchor_weights = anchor.weights;
  contact.anchor_m = anchor.point_base_m;
}

// The force blends to that of the new place, unless the surface has not moved.
void PutContact(const sculpt::SculptSurface& surface, ContactState& contact) noexcept {
  sculpt::KeptFeature proxy{contact.triangle, {}, contact.proxy_m, contact.normal};
  const double moved_m = sculpt::RebindFeature(surface, kReach_m, proxy);
  if (proxy.triangle == kNoIndex) {
    contact = {};
    return;
  }
  contact.triangle = proxy.triangle;
  contact.proxy_m = proxy.point_base_m;  // what holds the tip is found from there when the contact is followed
  if (contact.anchor_triangle != kNoIndex) PutAnchor(surface, contact);
  if (moved_m > sculpt::kStill_m) StartSwap(contact);
}

// The deepest contact with the object; kMaxContacts: none.
std::size_t DeepestOn(std::uint32_t object, const State& state) noexcept {
  std::size_t deepest = kMaxContacts;
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    const ContactState& c = state.contacts[k];
    if (!c.IsFelt() || c.object != object) continue;
    if (deepest == kMaxContacts || c.depth_m > state.contacts[deepest].depth_m) deepest = k;
  }
  return deepest;
}

sculpt::SculptTouch TouchOf(const sculpt::SculptTable& table, const ContactState& contact,
                            const ContactForce& force) noexcept {
  const sculpt::SculptSurface surface(table);
  const ClosestPoint at = ClosestOnTriangle(surface.TriangleCorners(contact.triangle), contact.proxy_m);
  return {true, contact.triangle, at.weights, contact.proxy_m, contact.normal, force.report.normal_force_N};
}

// The part of the contact's force that the tool has not taken over.
double ContactShare(const ContactScene& contact_scene, std::uint32_t object, const State& state) noexcept {
  const LiveParts* live = contact_scene.scene().live().get();
  for (std::uint32_t n = 0; live != nullptr && n < live->sculpt_session_count() && n < kMaxSculpted; ++n) {
    if (live->object_at(n) == object) return 1 - state.sculpted[n].tool.hold;
  }
  return 1;
}

}  // namespace

Vec3 ForceOnChanged(const ContactScene& contact_scene, const State& state) noexcept {
  Vec3 sum;
  for (const ContactState& contact : state.contacts) {
    if (!contact.IsFelt() || !contact_scene.ChangedUnderTip(contact.object)) continue;
    const double share = ContactShare(contact_scene, contact.object, state);
    sum = sum + share * contact_scene.FrameOf(contact.object).BaseDirection(contact.last_force_N);
  }
  return sum;
}

void StartLeaving(const ContactScene& contact_scene, const Vec3& before_N, State& state) noexcept {
  const Vec3 gone_N = before_N - ForceOnChanged(contact_scene, state);
  if (!(SquaredNorm(gone_N) > 1e-12)) return;
  state.left_N = gone_N + (state.left_fade_s / kSwapFade_s) * state.left_N;
  state.left_fade_s = kSwapFade_s;
}

Vec3 FadeLeaving(double dt_s, State& state) noexcept {
  state.left_fade_s = std::max(0.0, state.left_fade_s - dt_s);
  return state.left_fade_s > 0 ? (state.left_fade_s / kSwapFade_s) * state.left_N : Vec3{};
}

void RebindContacts(const ContactScene& contact_scene, State& state) noexcept {
  for (ContactState& contact : state.contacts) {
    if (!contact.active || !contact_scene.ChangedUnderTip(contact.object)) continue;
    const sculpt::SculptTable* table = contact_scene.TableOf(contact.object);
    if (table != nullptr) {
      PutContact(sculpt::SculptSurface(*table), contact);
    } else {
      contact = {};  // the object jumped away; if it is around the tip now, a new contact starts
    }
  }
}

Vec3 StepSculptTools(const StiffnessBound& bound, const ContactScene& contact_scene, const Input& input,
                     ContactForces& forces, State& state) noexcept {
  Vec3 sum;
  const LiveParts* live = contact_scene.scene().live().get();
  for (std::uint32_t n = 0; live != nullptr && n < live->sculpt_session_count() && n < kMaxSculpted; ++n) {
    const std::uint32_t object = live->object_at(n);
    const sculpt::SculptTable* table = contact_scene.TableOf(object);
    if (table == nullptr) continue;
    sculpt::SculptSession& sculpt_session = live->sculpt_session_at(n);
    const Frame frame = contact_scene.FrameOf(object);
    const Target target = contact_scene.TargetOf(object);
    sculpt::SculptInput tool;
    tool.tracked = input.tracked;
    tool.tip_base_m = target.tip;  // the tool works in the mesh's rest frame
    tool.dt_s = input.dt_s;
    tool.stiffness_limit_N_m = bound.stiffness_N_m;
    tool.normal_stiffness_limit_N_m = StiffnessAlong(bound, frame.BaseDirection(state.sculpted[n].tool.normal));
    tool.generation = table->generation;
    tool.releases = sculpt_session.releases();
    tool.brush = sculpt_session.brush();
    const std::size_t touched = DeepestOn(object, state);
    if (touched < kMaxContacts) tool.touch = TouchOf(*table, state.contacts[touched], forces.of[touched]);
    const auto out =
        sculpt::StepSculptTool(sculpt_session.parameters(), tool, state.sculpted[n].tool, sculpt_session.ring());
    for (std::size_t k = 0; k < kMaxContacts; ++k) {
      if (state.contacts[k].active && state.contacts[k].object == object) {
        forces.of[k].force_N = out.contact_share * forces.of[k].force_N;
      }
    }
    sum = sum + frame.BaseDirection(out.force_N);
  }
  return sum;
}

bool ToolsRest(const Scene& scene, const State& state) noexcept {
  if (scene.live() == nullptr) return true;
  for (std::uint32_t n = 0; n < scene.live()->sculpt_session_count() && n < kMaxSculpted; ++n) {
    const sculpt::SculptToolState& tool = state.sculpted[n].tool;
    const bool free = tool.phase == sculpt::SculptPhase::kFree;
    if (!free || tool.begin_waits || tool.end_waits || tool.hold > 0) return false;
  }
  return true;
}

bool SurfacesRest(const Scene& scene, const State& state) noexcept {
  for (std::uint32_t n = 0; n < scene.live()->sculpt_session_count() && n < kMaxSculpted; ++n) {
    const sculpt::SculptTable* table = scene.live()->sculpt_session_at(n).Acquire();
    if (table != nullptr && table->generation != state.sculpted[n].generation) return false;
  }
  return ToolsRest(scene, state);
}

}  // namespace omni::haptics
