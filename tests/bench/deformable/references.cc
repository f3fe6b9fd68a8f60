// Accuracy of the references.
#include <string>

#include "service/haptics/deformable/local_model.h"
#include "tests/bench/deformable/gain_fit.h"
#include "tests/bench/deformable/off_axis.h"
#include "tests/bench/deformable/rows.h"

namespace omni::bench {
namespace {

struct MeshStudy {
  std::string judge, mesh;
  AxisCurve curve;
};

// Compares every curve with the previous one in the list, and with `truth`, the other reference's, if that applies.
void AddStudy(const std::vector<MeshStudy>& study, const std::vector<double>& depths_m, const AxisCurve* truth,
              Rows& rows) {
  for (std::size_t i = 0; i < study.size(); ++i) {
    for (std::size_t k = 0; k < depths_m.size(); ++k) {
      const double force = study[i].curve.force_per_modulus_m2[k];
      nlohmann::ordered_json row{{"table", "reference mesh"},     {"judge", study[i].judge},
                                 {"mesh", study[i].mesh},         {"nodes", study[i].curve.nodes},
                                 {"depth_mm", depths_m[k] * 1e3}, {"force_N_at_0.2MPa", force * 2e5},
                                 {"change_pct", nullptr},         {"off_finest_axisymmetric_pct", nullptr}};
      if (truth != nullptr) row["off_finest_axisymmetric_pct"] = PercentOff(force, truth->force_per_modulus_m2[k]);
      if (i > 0 && study[i - 1].judge == study[i].judge) {
        row["change_pct"] = PercentOff(force, study[i - 1].curve.force_per_modulus_m2[k]);
      }
      rows.push_back(row);
    }
  }
}

void AddGain(const Settings& settings, Rows& rows) {
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

}  // namespace

void AddReferenceTables(const Settings& settings, Rows& rows) {
  const AxisBody body{"cylinder r30 h30", 0.03, 0.03, 0};
  const std::vector<double> depths_m{2e-4, 6e-4, 1.9e-3};
  std::vector<MeshStudy> study;
  for (const double finest_m : {5e-4, 2.5e-4, 1.25e-4, 8e-5}) {
    if (settings.quick && finest_m < 2e-4) break;
    study.push_back({"axisymmetric", std::to_string(static_cast<int>(finest_m * 1e6)) + " um",
                     PressBall(body, kPoisson, kBall_m, depths_m, {finest_m, 1.15})});
  }
  const AxisCurve truth = study.back().curve;
  const auto press_aside = [&](double aside_m, const SolidMesh& mesh) {
    study.push_back({aside_m == 0 ? "off-axis, at the axis" : "off-axis, 15 mm aside",
                     std::to_string(static_cast<int>(mesh.finest_m * 1e6)) + " um, order " + std::to_string(mesh.modes),
                     PressBallAside(body, aside_m, kPoisson, kBall_m, depths_m, mesh)});
  };
  // The second reference on the axis, where the first one applies; then off the axis, by Fourier order.
  const SolidMesh coarse{3.75e-4, 1.8, 2};
  press_aside(0, coarse);
  if (!settings.quick) press_aside(0, SolidMesh{});
  AddStudy(study, depths_m, &truth, rows);
  study.clear();
  for (const int order : {2, 4}) {
    if (!settings.quick) press_aside(0.015, {coarse.finest_m, coarse.growth, order});
  }
  AddStudy(study, depths_m, nullptr, rows);
  AddGain(settings, rows);
}

}  // namespace omni::bench
