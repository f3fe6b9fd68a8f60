// The surface as it is drawn: what the columns carry, plus the dents that are finer than a column.   (8.2)
#include <cmath>

#include "service/haptics/deformable/soft_contact.h"

namespace omni::haptics {
namespace {

constexpr double kDentReach_patches = 3;  // beyond, dent and patch are alike to 2 %

void AddScaled(double scale, const Float3& v, Vec3& sum) noexcept {
  sum = {sum.x + scale * v.x, sum.y + scale * v.y, sum.z + scale * v.z};
}

Vec3 Carried(const SoftBodyView& body, const SoftContactState& state, const SoftPlace& at) noexcept {
  const SoftTriangle& receiver = body.GetTriangle(at.triangle);
  Vec3 sum;
  for (const SoftSlot& slot : state.slots) {
    if (!(slot.active && slot.elastic_N > 0)) continue;
    const SoftTriangle& loaded = body.GetTriangle(slot.place.triangle);
    for (int j = 0; j < 3; ++j) {
      const Float3* column = body.Column(loaded.node[j]);
      for (int i = 0; i < 3; ++i) {
        AddScaled(slot.elastic_N * slot.place.weights[j] * at.weights[i], column[receiver.node[i]], sum);
      }
    }
  }
  return sum;
}

// What the column of a ball shows at the ball itself, beyond the body's actual displacement: the patch, to be
// subtracted.
double PatchDepth(const SoftBodyView& body, const SoftSlot& slot) noexcept {
  const SoftTriangle& t = body.GetTriangle(slot.place.triangle);
  Vec3 own;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      AddScaled(slot.elastic_N * slot.place.weights[j] * slot.place.weights[i], body.Column(t.node[j])[t.node[i]], own);
    }
  }
  return -Dot(own, slot.normal) - slot.carried_m;
}

// Hertz's dent with the radius it has, minus the patch: dent P(r / a) - patch P(r / rho), faded out.   (8.2)
Vec3 Dents(const SoftBodyView& body, const SoftContactState& state, const Vec3& p, double dent_share) noexcept {
  const double rho = body.header().patch_radius_m;
  Vec3 sum;
  for (const SoftSlot& slot : state.slots) {
    if (!(slot.active && slot.elastic_N > 0)) continue;
    const Vec3 away = p - slot.point_base_m;
    const double r = Norm(away);
    const double share = r / (kDentReach_patches * rho);
    if (!(share < 1) || Dot(away, slot.normal) < -rho) continue;  // far, or the other side of a thin part
    const double a = std::max(ContactPatchRadius(slot.model, slot.dent_m), 1e-9);
    const double depth = dent_share * slot.dent_m * DentProfile(r / a) - PatchDepth(body, slot) * DentProfile(r / rho);
    sum = sum - ((1 - share * share) * depth) * slot.normal;
  }
  return sum;
}

}  // namespace

Vec3 CarriedDisplacement(const SoftBodyView& body, const SoftContactState& state, const Vec3& point,
                         std::uint32_t hint) noexcept {
  return Carried(body, state, LocateOnSoftBody(body, point, hint)) + Dents(body, state, point, 0);
}

Vec3 SoftDisplacement(const SoftBodyView& body, const SoftContactState& state, const Vec3& point,
                      std::uint32_t hint) noexcept {
  return Carried(body, state, LocateOnSoftBody(body, point, hint)) + Dents(body, state, point, 1);
}

bool SurfaceDisplacement(const SoftBodyView& body, const SoftContactState& state, std::span<const Vec3> rest,
                         std::span<Float3> out) noexcept {
  const SoftHeader& h = body.header();
  if (out.size() != h.skin_count || rest.size() != h.skin_count) return false;
  std::array<Vec3, kMaxSoftNodes> nodes{};
  for (const SoftSlot& slot : state.slots) {
    if (!(slot.active && slot.elastic_N > 0)) continue;
    const SoftTriangle& loaded = body.GetTriangle(slot.place.triangle);
    for (int j = 0; j < 3; ++j) {
      const double scale = slot.elastic_N * slot.place.weights[j];
      const Float3* column = body.Column(loaded.node[j]);
      for (std::uint32_t i = 0; i < h.node_count; ++i) AddScaled(scale, column[i], nodes[i]);
    }
  }
  for (std::uint32_t v = 0; v < h.skin_count; ++v) {
    const SoftSkin& skin = body.Skin(v);
    const SoftTriangle& t = body.GetTriangle(skin.triangle);
    Vec3 sum = Dents(body, state, rest[v], 1);
    for (int k = 0; k < 3; ++k) sum = sum + static_cast<double>(skin.weights[k]) * nodes[t.node[k]];
    out[v] = {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z)};
  }
  return true;
}

}  // namespace omni::haptics
