// Force models of a contact: softness, stick-slip friction, vibration, viscosity, magnet, pop-through; and the
// haptic textures that a material's factors are multiplied with. docs/theory/haptics.md, sections 4 to 6.
#pragma once

#include <array>
#include <cstdint>

#include "service/base/vec.h"
#include "service/haptics/contact/proxy.h"
#include "service/haptics/haptics.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// A steady hum while touched.
struct VibrationEffect {
  double amplitude_N, frequency_Hz;
  double ForceOn(std::int64_t t_ns, double normal_force_N) const noexcept;
};

// Drag inside the volume.
struct ViscosityEffect {
  double viscosity_Ns_m, limit_Ns_m;
  Vec3 ForceOn(const Vec3& velocity_m_s) const noexcept;
};

// Pulls the tip to the surface from outside; zero at the surface and at `range_m`, strongest half-way.
struct MagnetEffect {
  double max_force_N, range_m;
  double ForceOn(double gap_m, double stiffness_limit_N_m) const noexcept;
};

// The skin gives way above a force.
struct PopThroughEffect {
  double threshold_N;
  bool GivesWay(double normal_force_N) const noexcept { return threshold_N > 0 && normal_force_N > threshold_N; }
};

// Soft surface: an elastic layer in series with the contact's stiffness, with one relaxing term   (section 4).
inline constexpr double kIndenterRadius_m = 0.003;  // of a tip that is a point
inline constexpr double kRelaxingShare = 0.3;       // instantaneous over long-term modulus, minus one

// Normal force of the whole contact at `depth_m`, without damping. Monotone in depth, slope at most `stiffness_N_m`.
// `softness.model` kNone: stiffness * depth. kTet: LayerForce. `ball_m`: radius of the tip, > 0.
double ElasticForce(const Softness& softness, double stiffness_N_m, double depth_m,
                    double ball_m = kIndenterRadius_m) noexcept;

// Adds the relaxing part; updates contact.elastic_N and contact.relaxation_N. kTet, before its body is ready: a
// half-space of its material   (4.4).
double LayerForce(const Softness& softness, double stiffness_N_m, double depth_m, double ball_m, double dt_s,
                  ContactState& contact) noexcept;

// Stick-slip friction with an anchor on the surface   (section 5).

// What the contact is now, before friction.
struct FrictionInput {
  Vec3 proxy;
  Vec3 normal;  // unit, in the direction of the normal force
  std::uint32_t proxy_triangle = kNoIndex;
  double normal_force_N = 0;
  double stiffness_N_m = 0;  // tangential, at most the normal one
  double static_friction = 0;
  double dynamic_friction = 0;
};

// Tangential force on the tool. Sets the anchor if the contact has none, moves it when slipping. Defined for Surface
// and sculpt::SculptSurface.
template <MeshView View>
Vec3 FrictionForce(const View& view, const FrictionInput& input, ContactState& contact) noexcept;

// Where the anchor is now; precondition: contact.anchor_triangle is set.
template <MeshView View>
Vec3 AnchorPosition(const View& view, const ContactState& contact) noexcept {
  const Corners c = view.TriangleCorners(contact.anchor_triangle);
  return contact.anchor_weights[0] * c[0] + contact.anchor_weights[1] * c[1] + contact.anchor_weights[2] * c[2];
}

// The value of a haptic texture at a place of the surface   ("Textures").

// In [0, 1], bilinear, at barycentric `weights` of `triangle`. 1 if `texture` is -1, or where the triangle's object has
// no coordinates for it, or they are not finite. Precondition: `texture` is -1 or below textures().size(), `triangle`
// below triangles().size().
float SampleTexture(const Scene& scene, std::int32_t texture, std::uint32_t triangle,
                    const std::array<double, 3>& weights) noexcept;

// In [0, 255], bilinear, at (u, v) of an image, (0, 0) its upper left corner and (1, 1) its lower right one. Not a
// number where they are not finite or beyond a billion repeats.
double SampleTexels(const Scene& scene, const Texture& texture, double u, double v) noexcept;

}  // namespace omni::haptics
