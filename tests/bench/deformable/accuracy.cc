#include <algorithm>
#include <cmath>

#include "tests/bench/deformable/rows.h"

namespace omni::bench {
namespace {

constexpr double kLargestForce_N = 2;
constexpr double kModuli_Pa[] = {2e5, 1e6};

// Errors of one kind of point.
struct Errors {
  std::vector<double> omni_pct, hertz_pct;
  double worst_change_pct = 0;  // of the references by their last refinement

  void Add(double omni, double hertz, double change) {
    omni_pct.push_back(std::abs(omni));
    hertz_pct.push_back(std::abs(hertz));
    worst_change_pct = std::max(worst_change_pct, std::abs(change));
  }
  void Add(const Errors& other) {
    omni_pct.insert(omni_pct.end(), other.omni_pct.begin(), other.omni_pct.end());
    hertz_pct.insert(hertz_pct.end(), other.hertz_pct.begin(), other.hertz_pct.end());
    worst_change_pct = std::max(worst_change_pct, other.worst_change_pct);
  }
};

double Share(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

// One body with the ball at one place, pressed in at all depths that stay below 2 N.
Errors JudgePlace(const Settings& settings, const AxisBody& body, const Place& place,
                  const std::vector<double>& depths_m, double modulus_Pa, const Reference& reference,
                  std::uint64_t seed, Rows& points) {
  Errors errors;
  haptics::SoftBuildReport report;
  const haptics::SoftBody soft =
      MakeSoft(body, {modulus_Pa, kPoisson, 1}, {0, 0, 1}, settings.quick ? 600 : settings.shipped_tets, seed, report);
  for (std::size_t k = 0; k < depths_m.size(); ++k) {
    const double reference_N = reference.force_per_modulus_m2[k] * modulus_Pa;
    if (reference_N > kLargestForce_N || !reference.converged) continue;
    const double omni = PercentOff(ForceAt(soft, body, place, depths_m[k]), reference_N);
    const double hertz = PercentOff(HertzPerModulus(depths_m[k]) * modulus_Pa, reference_N);
    errors.Add(omni, hertz, reference.change_pct[k]);
    points.push_back({{"table", "points"},
                      {"body", body.name},
                      {"aside_mm", place.aside_m * 1e3},
                      {"modulus_MPa", modulus_Pa / 1e6},
                      {"depth_mm", depths_m[k] * 1e3},
                      {"reference_N", reference_N},
                      {"reference_change_pct", reference.change_pct[k]},
                      {"omni_pct", omni},
                      {"hertz_pct", hertz},
                      {"tets", report.tets}});
  }
  return errors;
}

nlohmann::ordered_json Summary(const char* where, double modulus_Pa, const Errors& errors) {
  return {{"table", "accuracy"},
          {"place", where},
          {"modulus_MPa", modulus_Pa / 1e6},
          {"points", errors.omni_pct.size()},
          {"median_pct", Share(errors.omni_pct, 0.5)},
          {"p95_pct", Share(errors.omni_pct, 0.95)},
          {"worst_pct", Share(errors.omni_pct, 1)},
          {"hertz_worst_pct", Share(errors.hertz_pct, 1)},
          {"reference_change_worst_pct", errors.worst_change_pct}};
}

}  // namespace

void AddAccuracy(const Settings& settings, Rows& rows) {
  struct Kind {
    const char* name;
    int bodies, depths;
    bool aside;
  };
  const Kind kinds[] = {{"axis", settings.quick ? 1 : 4, 9, false}, {"aside", settings.quick ? 1 : 4, 6, true}};
  Rows points, summaries;
  Errors all;
  std::mt19937_64 rng(settings.seed * 7919);
  for (const Kind& kind : kinds) {
    Errors of_modulus[2];
    for (int b = 0; b < kind.bodies; ++b) {
      const AxisBody body = DrawBody(rng);
      const Place place = kind.aside ? DrawPlace(body, rng) : Place{};
      const std::vector<double> depths_m = DrawDepths(rng, kind.depths);
      const Reference reference = MakeReference(body, place.aside_m, depths_m, settings.quick);
      for (std::size_t m = 0; m < 2; ++m) {
        of_modulus[m].Add(JudgePlace(settings, body, place, depths_m, kModuli_Pa[m], reference, rng(), points));
      }
    }
    for (std::size_t m = 0; m < 2; ++m) {
      summaries.push_back(Summary(kind.name, kModuli_Pa[m], of_modulus[m]));
      all.Add(of_modulus[m]);
    }
  }
  const std::string reference =
      "neo-Hookean, worst of " + std::to_string(all.omni_pct.size()) + " points to 2 N on and off the axis";
  // The shipped lattice with one ball was timed before: one row for both.
  for (nlohmann::ordered_json& row : rows) {
    if (row.value("method", "") != "omni" || row.value("contact_nodes", 0) != 1) continue;
    row["error_pct"] = Share(all.omni_pct, 1);
    row["reference"] = reference;
  }
  rows.push_back({{"method", "study-hertz"},
                  {"tets", nullptr},
                  {"contact_nodes", 1},
                  {"us_median", nullptr},
                  {"us_p99", nullptr},
                  {"error_pct", Share(all.hertz_pct, 1)},
                  {"reference", reference}});
  rows.insert(rows.end(), summaries.begin(), summaries.end());
  rows.insert(rows.end(), points.begin(), points.end());
}

}  // namespace omni::bench
