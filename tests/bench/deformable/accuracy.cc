#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "service/haptics/deformable/soft_contact.h"
#include "tests/bench/deformable/gain_fit.h"
#include "tests/bench/deformable/rows.h"

namespace omni::bench {
namespace {

using haptics::ElasticModuli;

constexpr double kLargestForce_N = 2;

const std::vector<AxisBody>& Bodies() {
  static const std::vector<AxisBody> bodies{
      {"cylinder r30 h30", 0.03, 0.03, 0},    {"cylinder r20 h40", 0.02, 0.04, 0},
      {"plate r40 h15", 0.04, 0.015, 0},      {"dome R30 h30", 0.025, 0.03, 1 / 0.03},
      {"dome R60 h30", 0.03, 0.03, 1 / 0.06}, {"bowl R60 h30", 0.03, 0.03, -1 / 0.06},
      {"cylinder r15 h20", 0.015, 0.02, 0},
  };
  return bodies;
}

double HertzPerModulus(double depth_m, double ball_m) {
  return 4.0 / 3 / (1 - kPoisson * kPoisson) * std::sqrt(ball_m) * std::pow(depth_m, 1.5);
}

double PercentOff(double value, double reference) { return 100 * (value / reference - 1); }

struct Worst {
  double omni = 0, hertz = 0;
  int points = 0;
};

}  // namespace

haptics::SoftBody MakeSoft(const AxisBody& body, const ElasticModuli& moduli, const haptics::Vec3& fibre,
                           std::uint32_t tets, std::uint64_t seed, haptics::SoftBuildReport& report) {
  const SurfaceMesh mesh = TurnBody(body, 96, 48);
  haptics::SoftBodyOptions options;
  options.moduli = moduli;
  options.fibre = fibre;
  options.lattice.max_tets = tets;
  options.clamped_share = 2e-4;
  options.relaxing_share = 0;
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> shift(0.05, 0.45);
  options.lattice.shift_cells = {shift(rng), shift(rng), shift(rng)};
  auto soft = haptics::BuildSoftBody(mesh.vertices, mesh.triangles, options, report);
  if (!soft.ok()) {
    std::fprintf(stderr, "omni_bench_deformable: %s: %s\n", body.name.c_str(), soft.error().c_str());
    std::exit(1);
  }
  return *soft;
}

double ForceAtTop(const haptics::SoftBody& soft, const AxisBody& body, double depth_m) {
  haptics::SoftContactState state{};
  return haptics::StepSoftContact(soft.view(), {true, {0, 0, body.height_m}, {0, 0, 1}, depth_m, 0}, kBall_m, 1e-3,
                                  state)
      .elastic_N;
}

// Depths of the softer body first; both stop at 2 N of the reference.
void AddAccuracy(const Settings& settings, Rows& rows) {
  const std::vector<double> depths_m{1.5e-4, 3e-4, 4e-4, 4.5e-4, 6e-4, 8e-4, 1.2e-3, 1.6e-3, 1.9e-3};
  const AxisMesh mesh{settings.quick ? 4e-4 : 1e-4, 1.15};
  Rows points;
  Worst all;
  for (std::size_t b = 0; b < Bodies().size(); ++b) {
    if (settings.quick && b > 1) break;
    const AxisBody& body = Bodies()[b];
    const AxisCurve curve = PressBall(body, kPoisson, kBall_m, depths_m, mesh);
    for (const double modulus_Pa : {2e5, 1e6}) {
      haptics::SoftBuildReport report;
      const haptics::SoftBody soft = MakeSoft(body, {modulus_Pa, kPoisson, 1}, {0, 0, 1},
                                              settings.quick ? 600 : settings.shipped_tets, settings.seed + b, report);
      for (std::size_t k = 0; k < depths_m.size(); ++k) {
        const double reference_N = curve.force_per_modulus_m2[k] * modulus_Pa;
        if (reference_N > kLargestForce_N || !curve.converged) continue;
        const double omni = PercentOff(ForceAtTop(soft, body, depths_m[k]), reference_N);
        const double hertz = PercentOff(HertzPerModulus(depths_m[k], kBall_m) * modulus_Pa, reference_N);
        all = {std::max(all.omni, std::abs(omni)), std::max(all.hertz, std::abs(hertz)), all.points + 1};
        points.push_back({{"table", "points"},
                          {"body", body.name},
                          {"modulus_MPa", modulus_Pa / 1e6},
                          {"depth_mm", depths_m[k] * 1e3},
                          {"reference_N", reference_N},
                          {"omni_pct", omni},
                          {"hertz_pct", hertz},
                          {"tets", report.tets}});
      }
    }
  }
  const std::string reference = "neo-Hookean, axisymmetric, worst of " + std::to_string(all.points) + " points to 2 N";
  // The shipped lattice with one ball was timed before: one row for both.
  for (nlohmann::ordered_json& row : rows) {
    if (row.value("method", "") != "omni" || row.value("contact_nodes", 0) != 1) continue;
    row["error_pct"] = all.omni;
    row["reference"] = reference;
  }
  rows.push_back({{"method", "study-hertz"},
                  {"tets", nullptr},
                  {"contact_nodes", 1},
                  {"us_median", nullptr},
                  {"us_p99", nullptr},
                  {"error_pct", all.hertz},
                  {"reference", reference}});
  rows.insert(rows.end(), points.begin(), points.end());
}

void AddReferenceTables(const Settings& settings, Rows& rows) {
  const std::vector<double> depths_m{3e-4, 1e-3, 1.9e-3};
  std::vector<double> last;
  for (const double finest_m : {4e-4, 2e-4, 1e-4, 7e-5}) {
    if (settings.quick && finest_m < 2e-4) break;
    const AxisCurve curve = PressBall(Bodies()[0], kPoisson, kBall_m, depths_m, {finest_m, 1.15});
    for (std::size_t k = 0; k < depths_m.size(); ++k) {
      nlohmann::ordered_json row{{"table", "reference mesh"},
                                 {"finest_mm", finest_m * 1e3},
                                 {"nodes", curve.nodes},
                                 {"depth_mm", depths_m[k] * 1e3},
                                 {"force_N_at_0.2MPa", curve.force_per_modulus_m2[k] * 2e5},
                                 {"change_pct", nullptr}};
      if (!last.empty()) row["change_pct"] = PercentOff(curve.force_per_modulus_m2[k], last[k]);
      rows.push_back(row);
    }
    last = curve.force_per_modulus_m2;
  }
  const GainFit fit = FitGain({settings.quick ? 3e-4 : 1.2e-4, 1.15});
  for (std::size_t k = 0; k < 3; ++k) {
    rows.push_back({{"table", "gain"},
                    {"power_of_nu", k},
                    {"linear_fit", fit.linear[k]},
                    {"linear_shipped", haptics::kGainLinear[k]},
                    {"quadratic_fit", fit.quadratic[k]},
                    {"quadratic_shipped", haptics::kGainQuadratic[k]},
                    {"worst_residual_pct", 100 * fit.worst},
                    {"points", fit.points}});
  }
}

void AddLimits(const Settings& settings, Rows& rows) {
  const std::uint32_t tets = settings.quick ? 600 : settings.shipped_tets;
  const AxisBody block{"block r60 h60", 0.06, 0.06, 0};
  haptics::SoftBuildReport report;
  const haptics::SoftBody soft = MakeSoft(block, {2e5, kPoisson, 1}, {0, 0, 1}, tets, settings.seed, report);
  for (const double a_over_r : {0.02, 0.05, 0.1}) {
    const double depth_m = a_over_r * a_over_r * kBall_m;
    rows.push_back(
        {{"table", "hertz"},
         {"body", block.name},
         {"a_over_R", a_over_r},
         {"error_pct", PercentOff(ForceAtTop(soft, block, depth_m), HertzPerModulus(depth_m, kBall_m) * 2e5)}});
  }
  // The fibre turns about the axis of a body of revolution: nothing may change.
  const AxisBody round{"cylinder r30 h30", 0.03, 0.03, 0};
  std::vector<double> forces_N;
  for (int turn = 0; turn < (settings.quick ? 2 : 5); ++turn) {
    const double angle = turn * 0.39269908169872414;
    const haptics::SoftBody body =
        MakeSoft(round, {2e5, kPoisson, 4}, {std::cos(angle), std::sin(angle), 0}, tets, settings.seed, report);
    forces_N.push_back(ForceAtTop(body, round, 1e-3));
    rows.push_back({{"table", "fibre turned"},
                    {"fibre_ratio", 4},
                    {"angle_deg", 22.5 * turn},
                    {"force_N", forces_N.back()},
                    {"off_first_pct", PercentOff(forces_N.back(), forces_N.front())}});
  }
}

}  // namespace omni::bench
