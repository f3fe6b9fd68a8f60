#include "tests/bench/collision/judge.h"

#include <cmath>
#include <numbers>

#include "service/haptics/state.h"
#include "tests/bench/collision/engine.h"

namespace omni::collision {
namespace {

struct Check {
  std::vector<Vec3> tips;
  std::vector<double> distance_m;
  std::vector<bool> inside;
};

void CheckOracle(const Body& body, const Check& check, Verdict& verdict) {
  const std::vector<Brute> sums = SumOverAll(body, check.tips);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    ++verdict.checked;
    const bool same_side = (sums[i].winding > 0.5) == check.inside[i] || check.distance_m[i] < 1e-10;
    const bool same_distance = std::abs(std::sqrt(sums[i].distance_squared) - check.distance_m[i]) < 1e-12;
    verdict.oracle_wrong += !(same_distance && same_side);
  }
}

}  // namespace

void JudgePath(const Body& body, const Oracle& oracle, const haptics::Scene& scene, const std::vector<Vec3>& path,
               std::size_t check_every, Verdict& verdict) {
  haptics::State state;
  haptics::EnterScene(scene, state);
  const haptics::Config config = PlainConfig();
  haptics::Input input = PlainInput();
  haptics::Output output;
  Check check;
  Nearest nearest;
  nearest.triangle = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3& tip = path[i];
    input.device_point_base_m = tip;
    input.t_ns += 1'000'000;
    haptics::Step(config, scene, input, state, output);
    nearest = oracle.NearestTo(tip, nearest.triangle);
    const bool inside = oracle.IsInside(tip);
    const double distance_m = std::sqrt(nearest.distance_squared);
    if (check_every > 0 && i % check_every == check_every / 2) {
      check.tips.push_back(tip);
      check.distance_m.push_back(distance_m);
      check.inside.push_back(inside);
    }
    const bool felt = Norm(output.force_base_N) > 0;
    ++verdict.ticks;
    verdict.missed += inside && distance_m > kMissedDepth_m && !felt;
    verdict.wrong += !inside && distance_m > kFalseHeight_m && felt;
    verdict.outside += !inside;
    verdict.inside += inside;
    if (!inside || distance_m < kMissedDepth_m) continue;
    verdict.deepest_m = std::max(verdict.deepest_m, distance_m);
    if (!felt) continue;
    const Vec3 wanted = Normalized(nearest.point - tip), is = Normalized(output.force_base_N);
    verdict.direction_deg.push_back(std::atan2(Norm(Cross(wanted, is)), Dot(wanted, is)) * 180 / std::numbers::pi);
  }
  CheckOracle(body, check, verdict);
}

}  // namespace omni::collision
