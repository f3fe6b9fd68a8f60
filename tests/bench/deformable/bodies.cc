#include "tests/bench/deformable/bodies.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "service/haptics/deformable/soft_contact.h"
#include "tests/bench/deformable/off_axis.h"
#include "tests/support/soft_step.h"

namespace omni::bench {
namespace {

double Between(std::mt19937_64& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

}  // namespace

AxisBody DrawBody(std::mt19937_64& rng) {
  AxisBody body;
  body.radius_m = Between(rng, 0.014, 0.04);
  body.height_m = Between(rng, 0.012, 0.04);
  const double kind = Between(rng, 0, 3);
  // The cap stays above half of the height and flatter than 45 degrees at the rim.
  const double most = std::min(0.7 / body.radius_m, body.height_m / (body.radius_m * body.radius_m));
  if (kind > 1) body.cap_curvature_1_m = (kind > 2 ? -0.5 : 1) * most * Between(rng, 0.3, 1);
  char name[80];
  std::snprintf(name, sizeof(name), "%s r%.1f h%.1f",
                body.cap_curvature_1_m == 0 ? "cylinder" : (body.cap_curvature_1_m > 0 ? "dome" : "bowl"),
                1e3 * body.radius_m, 1e3 * body.height_m);
  body.name = name;
  if (body.cap_curvature_1_m != 0) {
    std::snprintf(name, sizeof(name), " R%.0f", 1e3 / std::abs(body.cap_curvature_1_m));
    body.name += name;
  }
  return body;
}

std::vector<double> DrawDepths(std::mt19937_64& rng, int count) {
  std::vector<double> depths_m;
  for (int k = 0; k < count; ++k) {
    depths_m.push_back(1.5e-4 * std::pow(13.0, std::clamp((k + Between(rng, 0.1, 0.9)) / count, 0.0, 1.0)));
  }
  return depths_m;
}

Place DrawPlace(const AxisBody& body, std::mt19937_64& rng) {
  const double most_m = body.radius_m - 2 * kBall_m;
  return {most_m * Between(rng, 0.2, 1), Between(rng, 0, 2 * std::numbers::pi)};
}

Reference MakeReference(const AxisBody& body, double aside_m, const std::vector<double>& depths_m, bool quick) {
  const auto press = [&](bool fine) {
    if (aside_m == 0)
      return PressBall(body, kPoisson, kBall_m, depths_m, {quick ? 4e-4 : (fine ? 1e-4 : 1.5e-4), 1.15});
    const SolidMesh mesh = fine ? SolidMesh{} : SolidMesh{3.75e-4, 1.8, 2};
    return PressBallAside(body, aside_m, kPoisson, kBall_m, depths_m, mesh);
  };
  const AxisCurve coarse = press(false);
  const AxisCurve fine = quick ? coarse : press(true);
  Reference reference{fine.force_per_modulus_m2, {}, fine.nodes, coarse.converged && fine.converged};
  for (std::size_t k = 0; k < depths_m.size(); ++k) {
    const double change_pct = PercentOff(fine.force_per_modulus_m2[k], coarse.force_per_modulus_m2[k]);
    reference.change_pct.push_back(quick ? std::nan("") : change_pct);
  }
  return reference;
}

haptics::SoftBody MakeSoft(const AxisBody& body, const haptics::ElasticModuli& moduli, const haptics::Vec3& fibre,
                           std::uint32_t tets, std::uint64_t seed, haptics::SoftBuildReport& report) {
  const SurfaceMesh mesh = TurnBody(body, 96, 48);
  haptics::SoftBodyOptions options;
  options.moduli = moduli;
  options.fibre = fibre;
  options.lattice.max_tets = tets;
  options.clamped_share = 2e-4;
  options.relaxing_share = 0;
  std::mt19937_64 rng(seed);
  options.lattice.shift_cells = {Between(rng, 0.05, 0.45), Between(rng, 0.05, 0.45), Between(rng, 0.05, 0.45)};
  auto soft = haptics::BuildSoftBody(mesh.vertices, mesh.triangles, options, report);
  if (!soft.ok()) {
    std::fprintf(stderr, "omni_bench_deformable: %s: %s\n", body.name.c_str(), soft.error().c_str());
    std::exit(1);
  }
  return *soft;
}

double ForceAt(const haptics::SoftBody& soft, const AxisBody& body, const Place& place, double depth_m) {
  const double r = place.aside_m;
  const double c = std::cos(place.angle_rad), s = std::sin(place.angle_rad);
  const double slope = body.TopSlope(r);
  const haptics::Vec3 normal = base::Normalized({-slope * c, -slope * s, 1});
  haptics::SoftContactState state{};
  return support::StepSoftContact(soft.view(), {true, {r * c, r * s, body.Top(r)}, normal, depth_m, 0}, kBall_m, 1e-3,
                                  state)
      .elastic_N;
}

double HertzPerModulus(double depth_m) {
  return 4.0 / 3 / (1 - kPoisson * kPoisson) * std::sqrt(kBall_m) * std::pow(depth_m, 1.5);
}

double PercentOff(double value, double reference) { return 100 * (value / reference - 1); }

}  // namespace omni::bench
