// Touching a soft body, once a millisecond: up to 16 balls, their forces and how stiff they are at this instant. Each
// ball acts against its own dent (local_model.h) in series with the displacement of the whole body (columns of the
// block), and on the others through the body. Cost does not depend on the number of tetrahedra.
// docs/theory/deformable.md, sections 6 to 8.
//
// Displaced proxy (8.1): keep the rigid proxy s on the REST surface, with the tip x - CarriedDisplacement(s). Then
//   contact.point = s, contact.normal = out of the surface, contact.depth = (s - x) . normal,
// and what is shown as the proxy is s + SoftDisplacement(s).
#pragma once

#include <span>

#include "service/haptics/deformable/local_model.h"
#include "service/haptics/deformable/soft_body.h"
#include "service/haptics/deformable/soft_contact_state.h"

namespace omni::haptics {

struct SoftContact {
  bool touching = false;
  Vec3 point_base_m;                 // on the rest surface
  Vec3 normal;                       // unit, out of the body
  double depth_m = 0;                // of the ball below the rest surface; NaN and <= 0: no force
  double series_compliance_m_N = 0;  // of a spring between depth and ball, 1 / its stiffness; >= 0
};

struct SoftForce {
  double normal_N = 0;   // along +normal on the ball, >= 0, with the relaxing part
  double elastic_N = 0;  // long-term part: what deforms the body
  double dent_m = 0;     // local indentation
  double slope_N_m = 0;  // d normal_N / d depth within this tick
};

// At most kMaxSoftContacts contacts; further ones get no force. `forces` as long as `contacts`. `dt_s` in [0, 0.1].
void StepSoftContacts(const SoftBodyView& body, std::span<const SoftContact> contacts, double ball_radius_m,
                      double dt_s, SoftContactState& state, std::span<SoftForce> forces) noexcept;

// How far the body carries this point of its surface, without the dents right under the balls.
Vec3 CarriedDisplacement(const SoftBodyView& body, const SoftContactState& state, const Vec3& point_base_m,
                         std::uint32_t hint = kNoSoftTriangle) noexcept;

// Where the surface is drawn: with the dents.
Vec3 SoftDisplacement(const SoftBodyView& body, const SoftContactState& state, const Vec3& point_base_m,
                      std::uint32_t hint = kNoSoftTriangle) noexcept;

// The same for every vertex of the mesh the body was made from (`rest_base_m`: its vertices), for drawing at 60-120 Hz
// from a copy of the state, off the tick. `out` as long as header().skin_count and `rest_base_m`; longer or shorter:
// nothing is written and false.
bool SurfaceDisplacement(const SoftBodyView& body, const SoftContactState& state, std::span<const Vec3> rest_base_m,
                         std::span<Float3> out) noexcept;

}  // namespace omni::haptics
