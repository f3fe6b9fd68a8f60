// Pens whose magnets are not the one of the calibration: the twin's base, calibrated as by `omni calibrate`, through
// the whole tick, compared with its truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick_config.h"
#include "service/room/room_watch.h"
#include "service/sim/twin/loopback.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "tests/support/hand/ordinary_hand.h"
#include "tests/support/rig/magnet_of_scan.h"

namespace omni::test {
namespace test_tools_pens {

using base::MagnetIdentity;
using base::Vec3;

constexpr std::uint64_t kPenSeed = 5;
constexpr double kSilentSigmas = 5;
constexpr double kTracked_m = 3e-3, kCoarse_m = 10e-3;

base::DeviceGeometry FastDevice() {
  base::DeviceGeometry device = config::DefaultDevice();
  device.sensor_noise_T = config::DefaultTwin().sensor.noise_lp_T;
  return device;
}

base::TruthParameters Room() {
  base::TruthParameters truth = config::RoomTwin();
  truth.effects.magnet_warming_K = 0;
  return truth;
}

// Once for all tests, and shorter than a person's.
const std::optional<base::Calibration>& Calibrated() {
  static const std::optional<base::Calibration> calibration = []() -> std::optional<base::Calibration> {
    const auto done = tools::CalibrateTwin(FastDevice(), kPenSeed, Room(), {.wave_s = 20, .touches = 40});
    if (!done.ok()) return std::nullopt;
    return done->outcome.calibration;
  }();
  return calibration;
}

struct Pens {
  sim::HandScript hand;
  std::vector<base::OtherPen> used;
  double warming_K = 0;
  bool calibrated = true;
  std::vector<tracker::KnownMagnet> known{};
};

sim::HandScript Waved(double duration_s, std::uint64_t seed = kPenSeed) {
  return sim::MakeOrdinaryHand(FastDevice(), {.seed = seed, .duration_s = duration_s});
}

// A second without a pen, then as `next`.
void Exchange(const sim::HandScript& next, sim::HandScript& hand) {
  sim::HandWaypoint away = next.waypoints.front();
  away.present = false;
  away.duration_s = 1;
  hand.waypoints.push_back(away);
  hand.waypoints.insert(hand.waypoints.end(), next.waypoints.begin() + 1, next.waypoints.end());
}

// Runs tick by tick.
class PenScenario {
 public:
  explicit PenScenario(const Pens& pens) {
    base::TruthParameters truth = Room();
    watch_.emplace(&*Calibrated());
    truth.effects.room.pens = pens.used;
    truth.effects.magnet_warming_K = pens.warming_K;
    truth.effects.run_s = pens.hand.duration_s();
    sim::PlantOptions plant{.seed = kPenSeed, .script = pens.hand};
    plant.truth = truth;
    base_ = std::make_unique<sim::Loopback>(device_, plant);
    config_ = pens.calibrated ? loop::MakeTickConfig(device_, *Calibrated()) : loop::MakeTickConfig(device_);
    for (const tracker::KnownMagnet& known : pens.known) {
      tracker::MagnetOptions& magnets = config_.tracker.magnets;
      magnets.known[static_cast<std::size_t>(magnets.known_count++)] = known;
    }
    magnet_.emplace(base_->core().Truth());
  }

  void Step() {
    base::HallScan scan;
    base_->Tick(scan);
    loop::Tick(config_, scan, {.t_ns = scan.t_ns}, scene_, *state_, *output_);
    base_->Write(output_->currents);
    const sim::TruthRow now = base_->core().Truth();
    centre_m_ = magnet_->At(scan.t_ns, now);
    if (++ticks_ % 100 < 5) watch_->Add({scan, output_->tool});
    ghosts_ += posed() && !now.present ? 1 : 0;
    silent_ += posed() && now.present && error_m() > kSilentSigmas * sigma_m() ? 1 : 0;
  }

  // Share of ticks whose three standard deviations are within so much.
  double Run(double seconds, double most_m = kTracked_m) {
    int tracked = 0;
    error_sum_m_ = 0;
    const int ticks = static_cast<int>(1000 * seconds);
    for (int i = 0; i < ticks; ++i) {
      Step();
      const bool good = posed() && 3 * sigma_m() <= most_m;
      tracked += good ? 1 : 0;
      if (good) error_sum_m_ += error_m();
    }
    mean_error_m_ = tracked > 0 ? error_sum_m_ / tracked : 0;
    return static_cast<double>(tracked) / ticks;
  }

  const base::ToolState& tool() const { return output_->tool; }
  bool posed() const { return tool().status == base::TrackingStatus::kTracking; }
  double error_m() const { return base::Norm(tool().position_base_m - centre_m_); }
  double sigma_m() const { return std::sqrt(tool().covariance[0] + tool().covariance[6] + tool().covariance[12]); }
  double mean_error_m() const { return mean_error_m_; }  // of the tracked ticks of the last Run
  int silent() const { return silent_; }
  int ghosts() const { return ghosts_; }
  std::string Findings() const {
    std::string all;
    for (const room::RoomFinding& finding : watch_->findings()) all += finding.kind + ": " + RoomText(finding) + "\n";
    return all;
  }

 private:
  const base::DeviceGeometry device_ = FastDevice();
  std::optional<room::RoomWatch> watch_;
  std::unique_ptr<sim::Loopback> base_;
  loop::TickConfig config_;
  const std::unique_ptr<loop::LoopState> state_ = std::make_unique<loop::LoopState>();
  const std::unique_ptr<loop::TickOutput> output_ = std::make_unique<loop::TickOutput>();
  const haptics::Scene scene_;
  std::optional<support::MagnetOfScan> magnet_;
  Vec3 centre_m_;
  double error_sum_m_ = 0, mean_error_m_ = 0;
  int ticks_ = 0, silent_ = 0, ghosts_ = 0;
};

class ToolsPens : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Moments, ToolsPens, testing::Values(0.75, 0.9, 0.95, 1.05, 1.1, 1.25));

TEST_P(ToolsPens, AnotherPenIsTrackedAndNamed) {
  ASSERT_TRUE(Calibrated());
  PenScenario scenario({.hand = Waved(8), .used = {{.moment_scale = GetParam()}}});
  scenario.Run(2);
  const double tracked = scenario.Run(6), error_m = scenario.mean_error_m();
  EXPECT_EQ(scenario.silent(), 0);
  EXPECT_NEAR(scenario.tool().moment_scale, GetParam(), 0.01);
  EXPECT_EQ(scenario.tool().magnet, MagnetIdentity::kNew);
  const std::string percent = std::to_string(std::lround(100 * std::abs(GetParam() - 1)));
  const std::string said = "this magnet is " + percent + " +- 1 % " + (GetParam() > 1 ? "stronger" : "weaker");
  EXPECT_NE(scenario.Findings().find(said), std::string::npos) << scenario.Findings();
  // As well as the own pen, but for the smaller field of a weaker one.
  PenScenario own({.hand = Waved(8)});
  own.Run(2);
  const double weaker = std::min(1.0, GetParam());
  EXPECT_GE(tracked, weaker * own.Run(6));
  EXPECT_LT(error_m, 1.2 * own.mean_error_m() / weaker);
}

TEST_P(ToolsPens, PenThatIsBroughtFromAfarIsNeverSilentlyWrong) {
  ASSERT_TRUE(Calibrated());
  for (const double away_m : {0.22, 0.3, 0.5}) {
    SCOPED_TRACE(away_m);
    const Vec3 far_m = away_m * Normalized(Vec3{0.4, 0.5, 0.7}), axis = Normalized(-1.0 * far_m);
    const Vec3 near_m{0.01, 0, 0.06};
    PenScenario scenario({.hand = {.waypoints = {{0, far_m, axis, true},
                                                 {1, far_m, axis, true},
                                                 {away_m / 0.4, near_m, Normalized(-1.0 * near_m), true},
                                                 {3, near_m, {0, 0, -1}, true}}},
                          .used = {{.moment_scale = GetParam()}}});
    scenario.Run(2 + away_m / 0.4);
    EXPECT_EQ(scenario.silent(), 0);
    EXPECT_GE(scenario.Run(1, kCoarse_m), 0.97);
    EXPECT_LT(scenario.mean_error_m(), 1e-3);
  }
}

// Own, other, own, other within a minute: each is what it is within a tenth of a second.
TEST(ToolsPen, PensUsedInTurnAreTrackedAtOnce) {
  ASSERT_TRUE(Calibrated());
  for (const double moment_scale : {0.9, 1.25}) {
    SCOPED_TRACE(moment_scale);
    Pens pens{.hand = Waved(4)};
    std::vector<double> begin_s{0};
    for (int k = 1; k < 4; ++k) {
      begin_s.push_back(pens.hand.duration_s() + 1);
      pens.used.push_back({.moment_scale = k % 2 == 1 ? moment_scale : 1, .from_s = begin_s.back() - 0.5});
      Exchange(Waved(k == 1 ? 12 : 4, kPenSeed + static_cast<std::uint64_t>(k)), pens.hand);
    }
    PenScenario scenario(pens);
    double now_s = 0;
    for (int k = 0; k < 4; ++k) {
      scenario.Run(begin_s[static_cast<std::size_t>(k)] + 0.2 - now_s);
      EXPECT_GE(scenario.Run(3), 0.97);
      now_s = begin_s[static_cast<std::size_t>(k)] + 3.2;
      const MagnetIdentity other = k == 1 ? MagnetIdentity::kNew : MagnetIdentity::kKnown;
      EXPECT_EQ(scenario.tool().magnet, k % 2 == 0 ? MagnetIdentity::kCalibrated : other);
      EXPECT_NEAR(scenario.tool().moment_scale, k % 2 == 0 ? 1 : moment_scale, 0.01);
      EXPECT_EQ(scenario.Findings().find("this magnet") == std::string::npos, k % 2 == 0) << scenario.Findings();
    }
    EXPECT_EQ(scenario.silent(), 0);
    EXPECT_EQ(scenario.ghosts(), 0);
  }
}

TEST(ToolsPen, KnownPenIsRecognisedAfterARestart) {
  ASSERT_TRUE(Calibrated());
  PenScenario scenario({.hand = Waved(2), .used = {{.moment_scale = 0.9}}, .known = {{0.901, 0.003}}});
  scenario.Run(0.3);
  EXPECT_GE(scenario.Run(1.5), 0.97);
  EXPECT_EQ(scenario.tool().magnet, MagnetIdentity::kKnown);
  EXPECT_EQ(scenario.silent(), 0);
}

TEST(ToolsPen, NewPenIsKnownAfterTenSeconds) {
  ASSERT_TRUE(Calibrated());
  PenScenario scenario({.hand = Waved(13), .used = {{.moment_scale = 1.1}}});
  scenario.Run(9);
  EXPECT_EQ(scenario.tool().magnet, MagnetIdentity::kNew);
  scenario.Run(4);
  EXPECT_EQ(scenario.tool().magnet, MagnetIdentity::kKnown);
}

// -1.8 % within half a minute, then it is put away and taken up again.
TEST(ToolsPen, PenThatGetsWarmStaysTheCalibratedOne) {
  ASSERT_TRUE(Calibrated());
  Pens pens{.hand = Waved(30), .warming_K = 15};
  const double before_s = pens.hand.duration_s();
  Exchange(Waved(3), pens.hand);
  PenScenario scenario(pens);
  EXPECT_GE(scenario.Run(before_s + 1.2), 0.93);
  EXPECT_GE(scenario.Run(2), 0.97);
  EXPECT_EQ(scenario.silent(), 0);
  EXPECT_EQ(scenario.tool().magnet, MagnetIdentity::kCalibrated);
  EXPECT_NEAR(scenario.tool().moment_scale, 1 - 0.018, 0.008);
  EXPECT_EQ(scenario.Findings().find("this magnet"), std::string::npos) << scenario.Findings();
}

TEST(ToolsPen, MuchWeakerOrStrongerMagnetIsNeverSilentlyWrong) {
  ASSERT_TRUE(Calibrated());
  for (const double moment_scale : {0.3, 0.4, 0.6, 1.4, 1.5}) {
    SCOPED_TRACE(moment_scale);
    PenScenario scenario({.hand = Waved(4), .used = {{.moment_scale = moment_scale}}});
    scenario.Run(4);
    EXPECT_EQ(scenario.silent(), 0);
  }
}

TEST(ToolsPen, AnotherPenOnAnUncalibratedBaseIsNotNamed) {
  ASSERT_TRUE(Calibrated());
  PenScenario scenario({.hand = Waved(6), .used = {{.moment_scale = 0.9}}, .calibrated = false});
  scenario.Run(6);
  EXPECT_EQ(scenario.tool().magnet, MagnetIdentity::kUnknown);
  EXPECT_EQ(scenario.Findings().find("this magnet"), std::string::npos) << scenario.Findings();
}

}  // namespace test_tools_pens
}  // namespace omni::test
