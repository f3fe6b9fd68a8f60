#include "service/haptics/contact/contacts.h"

#include "service/haptics/contact/contact_slots.h"
#include "service/haptics/contact/effects.h"
#include "service/haptics/contact/grating.h"
#include "service/haptics/contact/relief.h"
#include "service/haptics/contact/shading.h"
#include "service/haptics/contact/soft_touch.h"
#include "service/haptics/geometry/topology.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

// One contact in this tick, in its object's rest frame.
struct ContactGeometry {
  Frame frame;
  Vec3 velocity_m_s;  // of the tip, relative to the object
  Vec3 normal;        // unit, from the tip to the proxy
  double depth_m = 0;
  bool soft = false;  // its body computes the force
};

void Measure(const ContactScene& contact_scene, const Target& target, const ContactState& contact,
             ContactGeometry& met) noexcept {
  met.soft = contact_scene.SoftOf(target.index) != nullptr;
  if (met.soft) {
    const SoftPress press = PressOf(contact_scene, target, contact);
    met.normal = press.normal;
    met.depth_m = std::max(0.0, press.depth_m);
    return;
  }
  const Vec3 d = contact.held_m - target.tip;
  met.depth_m = Norm(d);
  if (met.depth_m > 1e-9) {
    met.normal = (1 / met.depth_m) * d;
    met.depth_m = std::max(0.0, met.depth_m - contact_scene.TipAt(target.index).skin_m);
    return;
  }
  met.normal = contact_scene.VisitSurface(target.index, [&](const auto& view) noexcept {
    return contact.side * Pseudonormal(view, contact.triangle, Feature::kFace, 0);
  });
}

// Force shading   (13.5): where a smooth body is touched at one place, its facets render as the surface they
// approximate.
void Shade(const ContactScene& contact_scene, const ContactState& contact, ContactGeometry& met) noexcept {
  met.normal = contact_scene.VisitSurface(contact.object, [&](const auto& view) noexcept {
    const ClosestPoint at = ClosestOnTriangle(view.TriangleCorners(contact.triangle), contact.proxy_m);
    return ShadedDirection(view, contact.triangle, at, met.normal);
  });
}

ContactGeometry MeasureContact(const ContactScene& contact_scene, const Input& input,
                               const ContactState& contact) noexcept {
  const Target target = contact_scene.TargetOf(contact.object);
  ContactGeometry met;
  met.frame = contact_scene.FrameOf(contact.object);
  const Vec3 relative = input.velocity_base_m_s - contact_scene.VelocityOf(contact.object, contact.proxy_m);
  met.velocity_m_s = met.frame.RestDirection(relative);
  Measure(contact_scene, target, contact, met);
  return met;
}

std::uint32_t MaterialIndex(const ContactScene& contact_scene, const ContactState& contact) noexcept {
  return contact_scene.VisitSurface(contact.object, [&](const auto& view) noexcept -> std::uint32_t {
    return view.GetTriangle(contact.triangle).material;
  });
}

const Material& MaterialOf(const ContactScene& contact_scene, const ContactState& contact) noexcept {
  return contact_scene.MaterialAt(MaterialIndex(contact_scene, contact));
}

// The material's factors at the proxy as scaled by its textures   (T.1).
struct SurfaceFactors {
  double stiffness = 1, friction = 1, ripple = 1;
};

// A sculpted surface has no texture coordinates any more.
SurfaceFactors FactorsAt(const ContactScene& contact_scene, const Material& m, const ContactState& contact) noexcept {
  if (m.stiffness_texture < 0 && m.friction_texture < 0 && m.vibrotactile_texture < 0) return {};
  if (contact_scene.TableOf(contact.object) != nullptr) return {};
  const Surface& surface = contact_scene.surface();
  const auto weights = ClosestOnTriangle(surface.TriangleCorners(contact.triangle), contact.proxy_m).weights;
  const auto sample = [&](std::int32_t texture) noexcept {
    return static_cast<double>(SampleTexture(contact_scene.scene(), texture, contact.triangle, weights));
  };
  return {sample(m.stiffness_texture), sample(m.friction_texture), sample(m.vibrotactile_texture)};
}

// The part of a velocity along a surface.
Vec3 SlipAlong(const Vec3& velocity_m_s, const Vec3& normal) noexcept {
  return velocity_m_s - Dot(velocity_m_s, normal) * normal;
}

// Computes one contact at a time, with the state that all share.
struct ContactModel {
  const StiffnessBound& bound;
  const ContactScene& contact_scene;
  const Input& input;
  double dt_s;

  // Damping acts inwards and outwards, but the sum never pulls   (3.8)
  double Normal(const Material& m, double elastic_N, const ContactGeometry& met) const noexcept {
    const double damping_Ns_m = std::clamp(m.damping_Ns_m, 0.0, bound.damping_Ns_m);
    return std::max(0.0, elastic_N - damping_Ns_m * Dot(met.velocity_m_s, met.normal));
  }

  double Ripple(const Material& m, const SurfaceFactors& factors, const ContactGeometry& met, double stiffness_N_m,
                double elastic_N, ContactState& contact) const noexcept {
    const VibrationEffect hum{m.vibration_amplitude_N, m.vibration_frequency_Hz};
    const double hum_N = hum.ForceOn(input.t_ns, elastic_N);
    const Grating grating{factors.ripple * m.texture_amplitude_m, m.texture_wavelength_m, m.texture_gain};
    const bool has_relief = m.relief >= 0 && m.relief_gain > 0 && contact_scene.TableOf(contact.object) == nullptr;
    if (!grating.IsFelt() && !has_relief) return hum_N;
    const SlidingTip tip{.place_m = contact.proxy_m,
                         .slip_m_s = SlipAlong(met.velocity_m_s, met.normal),
                         .ahead_s = bound.ahead_s,
                         .coil_lag_s = bound.coil_lag_s,
                         .dt_s = dt_s};
    double ripple_N = hum_N;
    if (grating.IsFelt()) {
      ripple_N += grating.ForceOn(tip, stiffness_N_m, elastic_N, contact.grating);
    } else {
      FollowPlace(tip, contact.grating);
    }
    if (!has_relief) return ripple_N;
    const Vec3 place_m = PlaceOfForce(tip, contact.grating);
    const double height_m =
        ReliefHeight(contact_scene.scene(), static_cast<std::uint32_t>(m.relief), contact_scene.surface(),
                     contact.triangle, place_m, Norm(contact.grating.slip_m_s));
    return ripple_N + ReliefForce(height_m, m.relief_gain, stiffness_N_m, elastic_N);
  }

  Vec3 Drag(const Material& m, const Object& object, const Vec3& velocity_m_s) const noexcept {
    if ((object.flags & kClosed) == 0) return {};
    const double left_Ns_m = std::max(0.0, bound.damping_Ns_m - m.damping_Ns_m);
    return ViscosityEffect{m.viscosity_Ns_m, left_Ns_m}.ForceOn(velocity_m_s);
  }

  // After the proxy moved to another place: from the force before to the force now   (2.3)
  void FadeSwap(ContactForce& result, ContactState& contact) const noexcept {
    if (contact.swap_left_s > 0) {
      const double old_share = contact.swap_left_s / kSwapFade_s;
      result.force_N = old_share * contact.swapped_from_N + (1 - old_share) * result.force_N;
      contact.swap_left_s = std::max(0.0, contact.swap_left_s - dt_s);
    }
    contact.last_force_N = result.force_N;
  }

  // `body_N`: the force of a soft body.
  ContactForce Of(const ContactGeometry& met, const SurfaceFactors& factors, double stiffness_N_m, double body_N,
                  ContactState& contact) const noexcept {
    const Material& m = MaterialOf(contact_scene, contact);
    ContactForce result;
    result.depth_m = met.depth_m;
    result.asked_stiffness_N_m = factors.stiffness * m.stiffness_N_m;
    result.stiffness_cut = result.asked_stiffness_N_m > 0 ? stiffness_N_m / result.asked_stiffness_N_m : 1;
    const double ball_m = PressRadius_m(contact_scene);
    result.elastic_N = met.soft ? body_N : LayerForce(m.softness, stiffness_N_m, met.depth_m, ball_m, dt_s, contact);
    const double tangential_N_m = met.depth_m > 1e-9 ? result.elastic_N / met.depth_m : 0;
    const double rubs_N_m = std::min({tangential_N_m, stiffness_N_m, bound.stiffness_N_m});  // any direction
    const Vec3 friction = Rub(met, factors, m, rubs_N_m, result.elastic_N, contact);
    const double normal_N = Normal(m, result.elastic_N, met);
    const double ripple_N = Ripple(m, factors, met, stiffness_N_m, result.elastic_N, contact);
    const Object& object = contact_scene.scene().objects()[contact.object];
    result.force_N = std::max(0.0, normal_N + ripple_N) * met.normal + friction + Drag(m, object, met.velocity_m_s);
    FadeSwap(result, contact);
    result.force_N = met.frame.BaseDirection(result.force_N);
    contact.normal = met.normal;
    result.report = {.object = contact.object,
                     .material = MaterialIndex(contact_scene, contact),
                     .triangle = contact.triangle,
                     .point_base_m = {},
                     .normal_base = met.frame.BaseDirection(met.normal),
                     .gap_m = -met.depth_m,
                     .normal_force_N = normal_N,
                     .tangential_force_N = Norm(friction),
                     .force_base_N = result.force_N,
                     .slip_base_m_s = met.frame.BaseDirection(SlipAlong(met.velocity_m_s, met.normal))};
    return result;
  }

  Vec3 Rub(const ContactGeometry& met, const SurfaceFactors& factors, const Material& m, double stiffness_N_m,
           double elastic_N, ContactState& contact) const noexcept {
    const FrictionInput rubbed{contact.proxy_m,
                               met.normal,
                               contact.triangle,
                               elastic_N,
                               stiffness_N_m,
                               factors.friction * m.static_friction,
                               factors.friction * std::min(m.dynamic_friction, m.static_friction)};
    return contact_scene.VisitSurface(contact.object, [&](const auto& view) noexcept {
      const Vec3 friction = FrictionForce(view, rubbed, contact);
      if (contact.anchor_triangle != kNoIndex) contact.anchor_m = AnchorPosition(view, contact);
      return friction;
    });
  }
};

void PopIfTooHard(const Material& m, const Object& object, bool ball, const ContactForce& force,
                  ContactState& contact) noexcept {
  if (!PopThroughEffect{m.pop_through_N}.GivesWay(force.elastic_N)) return;
  if (ball || HasInside(object)) {
    contact.popped = true;
  } else {
    contact = {};  // through the sheet
  }
}

// What the contacts have in common, before their forces.
struct ContactGeometries {
  std::array<ContactGeometry, kMaxContacts> met;
  std::array<SurfaceFactors, kMaxContacts> factors;
  std::array<double, kMaxContacts> stiffness_N_m{};
  std::array<double, kMaxContacts> load{};  // over the stiffness bound
  std::array<double, kMaxContacts> body_N{};
};

// Stiffness bound in the contact's direction; while the pen turns in contact it only falls, for a rise would push the
// hand.
double BoundTo(const StiffnessBound& bound, const Vec3& normal_base, ContactState& contact) noexcept {
  const double now_N_m = StiffnessAlong(bound, normal_base);
  contact.bound_N_m = contact.bound_N_m > 0 ? std::min(contact.bound_N_m, now_N_m) : now_N_m;
  return contact.bound_N_m;
}

ContactGeometries MeasureContacts(const ContactScene& contact_scene, const Input& input, const StiffnessBound& bound,
                                  State& state) noexcept {
  ContactGeometries all;
  std::array<double, kMaxContacts> load{};
  std::array<Vec3, kMaxContacts> normals_base;
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    ContactState& contact = state.contacts[k];
    if (!contact.IsFelt()) continue;
    all.met[k] = MeasureContact(contact_scene, input, contact);
    if (MaterialOf(contact_scene, contact).smooth && contact.one_place) Shade(contact_scene, contact, all.met[k]);
    normals_base[k] = all.met[k].frame.BaseDirection(all.met[k].normal);
    const Material& m = MaterialOf(contact_scene, contact);
    all.factors[k] = FactorsAt(contact_scene, m, contact);
    const double bound_N_m = BoundTo(bound, normals_base[k], contact);
    all.stiffness_N_m[k] = std::clamp(all.factors[k].stiffness * m.stiffness_N_m, 0.0, bound_N_m);
    load[k] = bound_N_m > 0 ? all.stiffness_N_m[k] / bound_N_m : 0;
  }
  const double share = StiffnessShare(normals_base, load);
  for (double& stiffness_N_m : all.stiffness_N_m) stiffness_N_m *= share;
  for (std::size_t k = 0; k < kMaxContacts; ++k) all.load[k] = share * load[k];
  return all;
}

// One step for every soft body that is touched, with all its contacts.
void QueryBodies(const ContactScene& contact_scene, double dt_s, ContactGeometries& all, State& state) noexcept {
  std::array<bool, kMaxContacts> asked{};
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    if (asked[k] || !state.contacts[k].IsFelt() || !all.met[k].soft) continue;
    const std::uint32_t object = state.contacts[k].object;
    std::array<SoftPress, kMaxContacts> press;
    for (std::size_t i = 0; i < kMaxContacts; ++i)
      press[i] = {all.met[i].normal, all.met[i].depth_m, all.stiffness_N_m[i]};
    const auto forces = SoftForcesOf(contact_scene, object, press, dt_s, state);
    for (std::size_t i = k; i < kMaxContacts; ++i) {
      if (!state.contacts[i].IsFelt() || state.contacts[i].object != object) continue;
      all.body_N[i] = forces[i].normal_N;
      asked[i] = true;
    }
  }
}

}  // namespace

ContactForces ForcesOf(const StiffnessBound& bound, const ContactScene& contact_scene, const Input& input,
                       State& state) noexcept {
  ContactGeometries all = MeasureContacts(contact_scene, input, bound, state);
  QueryBodies(contact_scene, input.dt_s, all, state);
  ContactForces forces;
  const ContactModel model{bound, contact_scene, input, input.dt_s};
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    ContactState& contact = state.contacts[k];
    if (!contact.IsFelt()) continue;
    const Material& m = MaterialOf(contact_scene, contact);
    ContactForce force = model.Of(all.met[k], all.factors[k], all.stiffness_N_m[k], all.body_N[k], contact);
    force.report.load = all.load[k];
    force.report.point_base_m = all.met[k].frame.ToBase(DeformedProxy(contact_scene, contact, state));
    PopIfTooHard(m, contact_scene.scene().objects()[contact.object], contact_scene.TipAt(contact.object).radius_m > 0,
                 force, contact);
    if (contact.IsFelt()) forces.of[k] = force;
  }
  return forces;
}

}  // namespace omni::haptics
