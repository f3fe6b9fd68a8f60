#include "service/haptics/contact/soft_touch.h"

#include "service/haptics/contact/effects.h"
#include "service/haptics/geometry/topology.h"

namespace omni::haptics {
namespace {

// The one the object has, else a free one; there are as many as contacts.
SoftTouch* SlotOf(std::uint32_t object, State& state) noexcept {
  SoftTouch* free = nullptr;
  for (SoftTouch& soft : state.soft) {
    if (soft.object == object) return &soft;
    if (soft.object == kNoIndex && free == nullptr) free = &soft;
  }
  if (free != nullptr) free->object = object;
  return free;
}

}  // namespace

double PressRadius_m(const ContactScene& contact_scene) noexcept {
  const double ball_m = contact_scene.tip_radius_m();
  return ball_m > 0 ? ball_m : kIndenterRadius_m;
}

// The direction to the proxy is that of a small difference where the dent is small; the face's normal steadies it.
SoftPress PressOf(const ContactScene& contact_scene, const Target& target, const ContactState& contact) noexcept {
  constexpr double kSteady_m = 2e-5;
  const Vec3 face = contact_scene.VisitSurface(
      target.index, [&](const auto& view) noexcept { return contact.side * FaceNormal(view, contact.triangle); });
  const Vec3 towards = contact.held_m - contact_scene.TipOver(target, contact);
  const Vec3 normal = Normalized(towards + kSteady_m * face);
  return {normal, Dot(contact.held_m - target.tip, normal) - contact_scene.TipAt(target.index).skin_m, 0};
}

std::array<SoftForce, kMaxContacts> SoftForcesOf(const ContactScene& contact_scene, std::uint32_t object,
                                                 const std::array<SoftPress, kMaxContacts>& press, double dt_s,
                                                 State& state) noexcept {
  std::array<SoftForce, kMaxContacts> forces{};
  const SoftBody* body = contact_scene.SoftOf(object);
  SoftTouch* soft = SlotOf(object, state);
  if (body == nullptr || soft == nullptr) return forces;
  std::array<SoftContact, kMaxContacts> contacts{};
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    const ContactState& contact = state.contacts[k];
    if (!contact.IsFelt() || contact.object != object || !(press[k].stiffness_N_m > 0)) continue;
    contacts[k] = {true, contact.proxy_m, press[k].normal, press[k].depth_m, 1 / press[k].stiffness_N_m};
  }
  StepSoftContacts(body->view(), contacts, PressRadius_m(contact_scene), dt_s, soft->body, forces);
  return forces;
}

Vec3 DeformedProxy(const ContactScene& contact_scene, const ContactState& contact, const State& state) noexcept {
  const SoftBody* body = contact_scene.SoftOf(contact.object);
  if (body == nullptr) return contact.proxy_m;
  for (const SoftTouch& soft : state.soft) {
    if (soft.object == contact.object)
      return contact.proxy_m + SoftDisplacement(body->view(), soft.body, contact.proxy_m);
  }
  return contact.proxy_m;
}

}  // namespace omni::haptics
