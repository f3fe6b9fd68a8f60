// omni-bench tips: a point and balls stroke bodies in six styles, judged by another model; and their cost on fine
// meshes.
#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "service/loop/realtime.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/timing.h"
#include "tests/support/touch/tip_bodies.h"
#include "tests/support/touch/tip_strokes.h"

namespace omni::bench {
namespace {

using haptics::BallVerdict;
using haptics::LeaningPen;
using haptics::Vec3;

constexpr double kTips_m[] = {0, 0.0005, 0.0015, 0.003};

nlohmann::ordered_json Row(double radius_m, const std::string& body, const char* style, std::uint64_t ticks) {
  return {{"tip", radius_m > 0 ? "ball" : "point"},
          {"radius_mm", 1e3 * radius_m},
          {"body", body},
          {"style", style},
          {"ticks", ticks}};
}

void AddTimes(double us_median, double us_p99, nlohmann::ordered_json& row) {
  row["us_median"] = us_median;
  row["us_p99"] = us_p99;
}

nlohmann::ordered_json JudgedRow(const haptics::BallBody& body, double radius_m, const haptics::NamedStyle& style,
                                 std::uint64_t ticks, std::uint64_t seed) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> us;
  const BallVerdict verdict =
      haptics::JudgeStrokes(body.object, radius_m, style.style, ticks, seed, [&us](LeaningPen& pen) {
        const Clock::time_point begin = Clock::now();
        pen.Step();
        us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
      });
  nlohmann::ordered_json row = Row(radius_m, body.name, style.name, verdict.ticks);
  row["inside"] = verdict.inside;
  row["inverted"] = verdict.inverted;
  row["missed"] = verdict.missed;
  row["false_contacts"] = verdict.false_contacts;
  row["through"] = verdict.through;
  AddTimes(tools::Quantile(us, 0.5), tools::Quantile(us, 0.99), row);
  return row;
}

// The same way over the same bumpy ball by a point and by the pen's ball, in turns: batches of either.
void AddPaired(std::uint64_t triangles, int batches, std::uint64_t seed, BenchRows& rows) {
  constexpr double kBody_m = 0.02, kTip_m = 0.0015, kPress_m = 5e-4;
  const int squares = static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / 12)));
  const haptics::InputObject body = haptics::sculpt::BumpyBall(squares, kBody_m);
  const haptics::Scene scenes[] = {haptics::Built(haptics::BallScene(body, 0)),
                                   haptics::Built(haptics::BallScene(body, kTip_m))};
  const haptics::Surface surface(scenes[0], {});
  std::vector<Vec3> feet, normals;
  haptics::Random random(seed);
  Vec3 d = Normalized(random.InBox(1)), turn = random.InBox(1);
  for (int k = 0; k < 20'000; ++k) {  // 100 mm/s
    turn = Normalized(turn + random.InBox(0.1));
    d = Normalized(d + (1e-4 / kBody_m) * Normalized(Cross(d, turn)));
    const auto at = support::NearestPoint(surface, scenes[0].objects()[0], kBody_m * d);
    feet.push_back(at.closest.point);
    normals.push_back(haptics::FaceNormal(surface, at.triangle));
  }
  CallTimer timers[2];
  LeaningPen pens[] = {LeaningPen(scenes[0], 0), LeaningPen(scenes[1], kTip_m)};
  for (int batch = 0; batch < batches; ++batch) {
    for (std::size_t n = 0; n < 2; ++n) {
      const double height_m = (n == 0 ? 0 : kTip_m) - kPress_m;
      timers[n].Batch([&](std::size_t k) {
        const std::size_t i = k % (2 * feet.size()), at = i < feet.size() ? i : 2 * feet.size() - 1 - i;
        pens[n].PutCentre(feet[at] + height_m * normals[at]);
        pens[n].Step();
      });
    }
  }
  for (std::size_t n = 0; n < 2; ++n) {
    const double tip_m = n == 0 ? 0 : kTip_m;
    rows.push_back(Row(tip_m, "bumpy ball of " + std::to_string(triangles / 1000) + "k", "slide", timers[n].calls()));
    for (const char* key : {"inside", "inverted", "missed", "false_contacts", "through"}) rows.back()[key] = nullptr;
    AddTimes(timers[n].us_median(), timers[n].us_p99(), rows.back());
  }
}

}  // namespace

base::Result<BenchRows> BenchTips(const BenchOptions& options) {
  loop::FlushDenormals();
  const std::uint64_t ticks = options.quick ? 200 : 2000;
  haptics::Random seeds(options.seed);
  BenchRows rows;
  for (const haptics::BallBody& body : haptics::TipBodies()) {
    for (const double radius_m : kTips_m) {
      for (const haptics::NamedStyle& style : haptics::kStrokeStyles)
        rows.push_back(JudgedRow(body, radius_m, style, ticks, seeds.Next()));
    }
  }
  const std::vector<std::uint64_t> sizes =
      options.quick ? std::vector<std::uint64_t>{10'000} : std::vector<std::uint64_t>{100'000, 400'000, 1'600'000};
  for (const std::uint64_t triangles : sizes) AddPaired(triangles, options.quick ? 5 : 200, seeds.Next(), rows);
  return rows;
}

}  // namespace omni::bench
