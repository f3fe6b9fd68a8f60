#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "service/haptics/deformable/soft_contact.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/deformable/rows.h"

namespace omni::bench {
namespace {

using haptics::SoftContact;
using haptics::Vec3;

constexpr int kBatchTicks = 100;

long InvoluntarySwitches() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

double At(std::vector<double>& values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

// Balls that wander over the flat top and go in and out, about 50 mm/s.
class Dance {
 public:
  Dance(const AxisBody& body, int balls, std::uint64_t seed) : body_(body), rng_(seed) {
    std::uniform_real_distribution<double> any(0, 6.28);
    for (int k = 0; k < balls; ++k) phase_.push_back({any(rng_), any(rng_), any(rng_)});
  }
  void Next(std::vector<SoftContact>& contacts) {
    ++tick_;
    contacts.resize(phase_.size());
    for (std::size_t k = 0; k < phase_.size(); ++k) {
      const double t = 0.003 * tick_;
      const double r = 0.8 * body_.radius_m * std::abs(std::sin(phase_[k].x + 0.31 * t));
      const double angle = phase_[k].y + 0.7 * t;
      contacts[k] = {true,
                     {r * std::cos(angle), r * std::sin(angle), body_.height_m},
                     {0, 0, 1},
                     1e-3 + 1.2e-3 * std::sin(phase_[k].z + 3 * t),
                     0};
    }
  }

 private:
  const AxisBody& body_;
  std::mt19937_64 rng_;
  std::vector<Vec3> phase_;
  int tick_ = 0;
};

struct TickTime {
  double median_us = tools::kNotMeasured, p99_us = tools::kNotMeasured;
  std::size_t ticks = 0;
};

// Over all ticks of those batches in which the thread kept the core.
TickTime TimeTicks(const haptics::SoftBody& soft, const AxisBody& body, int balls, const Settings& settings) {
  Dance dance(body, balls, settings.seed);
  haptics::SoftContactState state{};
  std::vector<SoftContact> contacts;
  std::vector<haptics::SoftForce> forces(static_cast<std::size_t>(balls));
  std::vector<double> us;
  for (int batch = 0; batch < (settings.quick ? 300 : 3000); ++batch) {
    const std::size_t kept = us.size();
    const long before = InvoluntarySwitches();
    for (int tick = 0; tick < kBatchTicks; ++tick) {
      dance.Next(contacts);
      const auto begin = std::chrono::steady_clock::now();
      haptics::StepSoftContacts(soft.view(), contacts, kBall_m, 1e-3, state, forces);
      us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    }
    if (InvoluntarySwitches() != before) us.resize(kept);
  }
  if (us.empty()) return {};
  return {At(us, 0.5), At(us, 0.99), us.size()};
}

}  // namespace

void AddTiming(const Settings& settings, Rows& rows) {
  const AxisBody body{"cylinder r30 h30", 0.03, 0.03, 0};
  for (const std::uint32_t tets : {kStudyTets[0], settings.shipped_tets, kStudyTets[1]}) {
    if (settings.quick && tets > 600) break;
    haptics::SoftBuildReport report;
    const haptics::SoftBody soft = MakeSoft(body, {2e5, kPoisson, 1}, {0, 0, 1}, tets, settings.seed, report);
    for (const int balls : {1, 4, 16}) {
      const TickTime time = TimeTicks(soft, body, balls, settings);
      rows.push_back({{"method", tets == settings.shipped_tets || settings.quick ? "omni" : "study-omni-tets"},
                      {"tets", report.tets},
                      {"contact_nodes", balls},
                      {"us_median", time.median_us},
                      {"us_p99", time.p99_us},
                      {"error_pct", nullptr},
                      {"reference", "time only, " + std::to_string(time.ticks) + " undisturbed ticks"}});
    }
    rows.push_back({{"table", "precompute"},
                    {"tets", report.tets},
                    {"nodes", report.nodes},
                    {"surface_nodes", report.surface_nodes},
                    {"lattice_ms", report.lattice_ms},
                    {"factor_ms", report.factor_ms},
                    {"columns_ms", report.columns_ms},
                    {"MB", static_cast<double>(report.bytes) / 1e6}});
  }
}

}  // namespace omni::bench
