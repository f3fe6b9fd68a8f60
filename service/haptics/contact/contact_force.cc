#include "service/haptics/contact/contact_force.h"

#include "service/haptics/contact/contact_set.h"
#include "service/haptics/contact/effects.h"
#include "service/haptics/contact/friction.h"
#include "service/haptics/contact/softness.h"
#include "service/haptics/contact/texture.h"
#include "service/haptics/geometry/topology.h"

namespace omni::haptics {
namespace {

// Direction and size of the penetration of one contact.
struct Penetration {
  Vec3 normal;  // unit, from the tip to the proxy
  double depth_m = 0;
};

Penetration Measure(const Surface& surface, const ContactState& contact, const Vec3& tip) noexcept {
  const Vec3 d = contact.proxy_base_m - tip;
  const double depth_m = Norm(d);
  if (depth_m > 1e-9) return {(1 / depth_m) * d, depth_m};
  return {contact.side * Pseudonormal(surface, contact.triangle, Feature::kFace, 0), depth_m};
}

// What images make of the material's factors at the proxy   (T.1).
struct Felt {
  double stiffness = 1, friction = 1, ripple = 1;
};

Felt FeltAt(const Scene& scene, const Surface& surface, const Material& m, const ContactState& contact) noexcept {
  if (m.stiffness_texture < 0 && m.friction_texture < 0 && m.vibrotactile_texture < 0) return {};
  const auto weights = ClosestOnTriangle(surface.TriangleCorners(contact.triangle), contact.proxy_base_m).weights;
  const auto sample = [&](std::int32_t texture) noexcept {
    return static_cast<double>(SampleTexture(scene, texture, contact.triangle, weights));
  };
  return {sample(m.stiffness_texture), sample(m.friction_texture), sample(m.vibrotactile_texture)};
}

// One contact at a time, with what all share.
struct Law {
  const Offer& offer;
  const Scene& scene;
  const Surface& surface;
  const Input& input;
  double dt_s;

  // Damping acts on the way in and out, but the sum never pulls   (3.7)
  double Normal(const Material& m, double elastic_N, const Vec3& normal) const noexcept {
    const double damping_Ns_m = std::clamp(m.damping_Ns_m, 0.0, offer.damping_Ns_m);
    return std::max(0.0, elastic_N - damping_Ns_m * Dot(input.velocity_base_m_s, normal));
  }

  double Ripple(const Material& m, const Felt& felt, double stiffness_N_m, double elastic_N, double slid_m,
                double& phase) const noexcept {
    const TextureEffect texture{felt.ripple * m.texture_amplitude_m, m.texture_wavelength_m, m.texture_gain};
    const VibrationEffect hum{m.vibration_amplitude_N, m.vibration_frequency_Hz};
    return texture.ForceOn(stiffness_N_m, elastic_N, slid_m, dt_s, phase) + hum.ForceOn(input.t_ns, elastic_N);
  }

  Vec3 Drag(const Material& m, const Object& object) const noexcept {
    if ((object.flags & kClosed) == 0) return {};
    const double left_Ns_m = std::max(0.0, offer.damping_Ns_m - m.damping_Ns_m);
    return ViscosityEffect{m.viscosity_Ns_m, left_Ns_m}.ForceOn(input.velocity_base_m_s);
  }

  // After the proxy moved to another face: from the force before to the force now   (2.3). While nothing fades, the
  // present force is kept as the one to fade from.
  void FadeSwap(ContactForce& result, ContactState& contact) const noexcept {
    if (contact.swap_left_s > 0) {
      const double old_share = contact.swap_left_s / kSwapFade_s;
      result.force_N = old_share * contact.swapped_from_N + (1 - old_share) * result.force_N;
      contact.swap_left_s = std::max(0.0, contact.swap_left_s - dt_s);
    } else {
      contact.swapped_from_N = result.force_N;
    }
  }

  ContactForce Of(const Penetration& at, const Felt& felt, double stiffness_N_m, const Vec3& last_proxy,
                  double& texture_phase, ContactState& contact) const noexcept {
    const Triangle& triangle = surface.GetTriangle(contact.triangle);
    const Material& m = scene.materials()[triangle.material];
    ContactForce result;
    result.depth_m = at.depth_m;
    result.asked_stiffness_N_m = felt.stiffness * m.stiffness_N_m;
    result.stiffness_cut = result.asked_stiffness_N_m > 0 ? stiffness_N_m / result.asked_stiffness_N_m : 1;
    result.elastic_N = LayerForce(m.softness, stiffness_N_m, at.depth_m, dt_s, contact);
    const double tangential_N_m = at.depth_m > 1e-9 ? result.elastic_N / at.depth_m : 0;
    const Vec3 friction = FrictionForce(
        surface,
        {contact.proxy_base_m, at.normal, contact.triangle, result.elastic_N, std::min(tangential_N_m, stiffness_N_m),
         felt.friction * m.static_friction, felt.friction * std::min(m.dynamic_friction, m.static_friction)},
        contact);
    const double slid_m = contact.sticking ? 0 : Norm(contact.proxy_base_m - last_proxy);
    const double normal_N = Normal(m, result.elastic_N, at.normal);
    const double ripple_N = Ripple(m, felt, stiffness_N_m, result.elastic_N, slid_m, texture_phase);
    result.force_N =
        std::max(0.0, normal_N + ripple_N) * at.normal + friction + Drag(m, scene.objects()[contact.object]);
    result.report = {contact.object, triangle.material, contact.triangle, contact.proxy_base_m,
                     at.normal,      -at.depth_m,       normal_N,         Norm(friction)};
    FadeSwap(result, contact);
    return result;
  }
};

void PopIfTooHard(const Material& m, const Object& object, const ContactForce& force, ContactState& contact) noexcept {
  if (!PopThroughEffect{m.pop_through_N}.GivesWay(force.elastic_N)) return;
  const bool has_inside = (object.flags & kClosed) != 0 && (object.flags & kDoubleSided) == 0;
  if (has_inside) {
    contact.popped = true;
  } else {
    contact = {};  // through the sheet
  }
}

}  // namespace

ContactForces ForcesOf(const Offer& offer, const Scene& scene, const Surface& surface, const Input& input,
                       const std::array<Vec3, kMaxContacts>& last_proxy, State& state) noexcept {
  const double limit_N_m = offer.stiffness_N_m;
  std::array<Penetration, kMaxContacts> at;
  std::array<Vec3, kMaxContacts> normals;
  std::array<double, kMaxContacts> stiffness_N_m{};
  std::array<Felt, kMaxContacts> felt;
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    const ContactState& contact = state.contacts[k];
    if (!contact.active || contact.popped) continue;
    at[k] = Measure(surface, contact, input.device_point_base_m);
    normals[k] = at[k].normal;
    const Material& m = scene.materials()[surface.GetTriangle(contact.triangle).material];
    felt[k] = FeltAt(scene, surface, m, contact);
    stiffness_N_m[k] = std::clamp(felt[k].stiffness * m.stiffness_N_m, 0.0, limit_N_m);
  }
  const double share = StiffnessShare(normals, stiffness_N_m, kMaxContacts, limit_N_m);
  ContactForces forces;
  const Law law{offer, scene, surface, input, input.dt_s};
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    ContactState& contact = state.contacts[k];
    if (!contact.active || contact.popped) continue;
    const Material& m = scene.materials()[surface.GetTriangle(contact.triangle).material];
    ContactForce force = law.Of(at[k], felt[k], share * stiffness_N_m[k], last_proxy[k], state.texture_phase, contact);
    const Object& object = scene.objects()[contact.object];
    PopIfTooHard(m, object, force, contact);
    if (contact.active && !contact.popped) forces.of[k] = force;
  }
  return forces;
}

}  // namespace omni::haptics
