#include "service/haptics/contact/friction.h"

#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics {
namespace {

void SetAnchor(std::uint32_t triangle, const ClosestPoint& at, ContactState& contact) noexcept {
  contact.anchor_triangle = triangle;
  contact.anchor_weights = at.weights;
}

// The anchor's displacement from the proxy, in the tangent plane.
template <MeshView View>
Vec3 StretchOf(const View& view, const FrictionInput& input, const ContactState& contact) noexcept {
  const Vec3 u = AnchorPosition(view, contact) - input.proxy;
  return u - Dot(u, input.normal) * input.normal;
}

}  // namespace

// Stick: F_t = k u, u = anchor - proxy, while |F_t| <= mu_s F_n. Slip: the anchor is dragged so that |F_t| = mu_d F_n;
// a tick in which it need not be dragged sticks again.   (5.1)-(5.3)
template <MeshView View>
Vec3 FrictionForce(const View& view, const FrictionInput& input, ContactState& contact) noexcept {
  if (!(input.static_friction > 0) || !(input.stiffness_N_m > 0)) {
    contact.anchor_triangle = kNoIndex;
    contact.sticking = false;
    return {};
  }
  if (contact.anchor_triangle == kNoIndex) {
    SetAnchor(input.proxy_triangle, ClosestOnTriangle(view.TriangleCorners(input.proxy_triangle), input.proxy),
              contact);
    contact.sticking = true;
  }
  const Vec3 u = StretchOf(view, input, contact);
  const double length_m = Norm(u);
  const double mu = contact.sticking ? input.static_friction : input.dynamic_friction;
  if (input.stiffness_N_m * length_m <= mu * input.normal_force_N) {
    contact.sticking = true;
    return input.stiffness_N_m * u;
  }
  contact.sticking = false;
  const double allowed_m = input.dynamic_friction * input.normal_force_N / input.stiffness_N_m;
  const Vec3 dragged = (allowed_m / length_m) * u;
  const ProxyPoint anchor = Descend(view, input.proxy_triangle, input.proxy + dragged);
  SetAnchor(anchor.triangle, anchor.closest, contact);
  return input.stiffness_N_m * dragged;
}

template Vec3 FrictionForce(const Surface&, const FrictionInput&, ContactState&) noexcept;
template Vec3 FrictionForce(const sculpt::SculptSurface&, const FrictionInput&, ContactState&) noexcept;

}  // namespace omni::haptics
