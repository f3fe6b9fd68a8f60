// What users see about sensors and the room: the twin's base, calibrated, through the whole tick; RoomWatch receives
// what omnid would pass to it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick_config.h"
#include "service/room/room_watch.h"
#include "service/sim/twin/loopback.h"
#include "tests/support/hand/ordinary_hand.h"
#include "tests/support/rig/rig.h"

namespace omni::test {
namespace test_room_watch {

using base::TruthParameters;
using Kind = base::SensorFaultKind;

constexpr double kEvent_s = 3;
constexpr double kNamed_s = 10;  // after the event
constexpr std::uint64_t kIdleDivider = 16;

base::DeviceGeometry Device() {
  base::DeviceGeometry device = config::DefaultDevice();
  device.sensor_noise_T = config::DefaultTwin().sensor.noise_lp_T;
  return device;
}

// What a perfect calibration would find.
base::Calibration CalibrationOf(const base::DeviceGeometry& device, const TruthParameters& truth, std::uint64_t seed) {
  const sim::Rig rig(device,
                     {.seed = seed, .sizes = truth.imperfections, .effects = truth.effects, .sensor = truth.sensor});
  base::Calibration calibration = rig.ExactCalibration();
  calibration.expected_error_m = 1e-4;
  return calibration;
}

enum class Pen { kAway, kWaved, kHeld };

struct Scenario {
  std::uint64_t seed = 5;
  bool ideal = false;
  Pen pen = Pen::kWaved;
  bool idle = false;  // no application: the tick runs as slowly as without a pen
  std::function<void(TruthParameters&)> event = [](TruthParameters&) {};
  double run_s = kEvent_s + kNamed_s;
};

sim::HandScript HandOf(const Scenario& scenario, const base::DeviceGeometry& device) {
  if (scenario.pen == Pen::kAway) return {};
  if (scenario.pen == Pen::kWaved)
    return sim::MakeOrdinaryHand(device, {.seed = scenario.seed, .duration_s = scenario.run_s});
  sim::HandScript held;
  held.waypoints = {{0, {0.01, 0, 0.06}, {0, 0, -1}, true}, {scenario.run_s, {0.01, 0, 0.06}, {0, 0, -1}, true}};
  return held;
}

struct Reported {
  std::vector<room::RoomFinding> last;
  std::set<std::string> kinds;                  // ever reported
  bool early = false;                           // before the event
  std::optional<base::Vec3> before_T, after_T;  // field about the base: just before the event, at the end
};

// `wanted`: ends when it is reported.
Reported Watch(const Scenario& scenario, const std::string& wanted = {}) {
  const base::DeviceGeometry device = Device();
  TruthParameters truth = scenario.ideal ? config::IdealTwin() : config::RoomTwin();
  const base::Calibration calibration = CalibrationOf(device, truth, scenario.seed);
  scenario.event(truth);
  sim::PlantOptions plant{.seed = scenario.seed, .script = HandOf(scenario, device)};
  plant.truth = truth;
  sim::Loopback base(device, plant);
  const loop::TickConfig config = loop::MakeTickConfig(device, calibration);
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  const haptics::Scene scene;
  const bool idle = scenario.idle || scenario.pen == Pen::kAway;
  room::RoomWatch watch(&calibration);
  base::HallScan scan;
  Reported reported;
  for (int tick = 1; tick <= 1000 * scenario.run_s; ++tick) {
    base.Tick(scan);
    if (idle && scan.sequence % kIdleDivider != 0) continue;
    loop::Tick(config, scan, {.t_ns = scan.t_ns}, scene, *state, *output);
    base.Write(output->currents);
    if (tick % 100 >= (idle ? static_cast<int>(kIdleDivider) : 1)) continue;
    watch.Add({scan, output->tool});
    if (watch.field() && tick < 1000 * kEvent_s) reported.before_T = watch.field()->field_base_T;
    if (watch.field()) reported.after_T = watch.field()->field_base_T;
    for (const room::RoomFinding& finding : watch.findings()) {
      reported.kinds.insert(finding.kind);
      reported.early = reported.early || tick < 1000 * kEvent_s;
      if (finding.kind == wanted) tick = static_cast<int>(1000 * scenario.run_s);
    }
  }
  reported.last = watch.findings();
  return reported;
}

void ExpectReported(const Scenario& scenario, const std::string& kind, const std::vector<int>& sensors,
                    std::initializer_list<const char*> words) {
  const Reported reported = Watch(scenario, kind);
  EXPECT_FALSE(reported.early);
  std::string all;
  for (const room::RoomFinding& finding : reported.last) all += finding.kind + ": " + room::RoomText(finding) + "\n";
  const auto found =
      std::find_if(reported.last.begin(), reported.last.end(), [&](const auto& f) { return f.kind == kind; });
  ASSERT_NE(found, reported.last.end()) << kind << " is not reported, but: " << all;
  EXPECT_EQ(found->sensors, sensors) << all;
  for (const char* word : words) {
    EXPECT_NE(room::RoomText(*found).find(word), std::string::npos) << word << " not in: " << all;
  }
}

std::function<void(TruthParameters&)> Fault(Kind kind, int sensor, double value = 0, int other = 0) {
  return [=](TruthParameters& truth) {
    truth.effects.room.faults.push_back(
        {.kind = kind, .sensor = sensor, .other = other, .value = value, .from_s = kEvent_s});
  };
}

std::function<void(TruthParameters&)> SecondPen(double away_m) {
  return [=](TruthParameters& truth) {
    truth.effects.room.magnets.push_back({.moment_Am2 = {0.7, 0.5, 0.3},
                                          .from_base_m = {1, 0, 0},
                                          .to_base_m = {away_m, 0, 0},
                                          .leaves_s = kEvent_s,
                                          .arrives_s = kEvent_s + 1});
  };
}

void AmbientStep(TruthParameters& truth) {
  truth.effects.room.steps.push_back({.change_base_T = {40e-6, 30e-6, 33e-6}, .at_s = kEvent_s});
}

std::function<void(TruthParameters&)> SteelLater(double z_m) {
  return [=](TruthParameters& truth) {
    truth.effects.room.steel.push_back(
        {.shape = base::SteelShape::kPlane, .position_base_m = {0, 0, z_m}, .strength = 1, .from_s = kEvent_s});
  };
}

TEST(RoomWatch, WrongGainBlamesTheSensorOnlyAfterThePenMoved) {
  ExpectReported({.event = Fault(Kind::kGain, 3, 1.1)}, "sensor-wrong", {3},
                 {"sensor 3 reads wrong", "left out", "omni"});
  ExpectReported({.pen = Pen::kHeld, .event = Fault(Kind::kGain, 3, 1.1)}, "sensor-doubtful", {3},
                 {"sensor 3, or a magnet near it", "take magnets and steel away"});
}

TEST(RoomWatch, StuckSensorIsReportedWithAndWithoutPen) {
  for (const Pen pen : {Pen::kWaved, Pen::kAway}) {
    SCOPED_TRACE(static_cast<int>(pen));
    ExpectReported({.pen = pen, .event = Fault(Kind::kStuck, 6)}, "sensor-repeats", {6},
                   {"sensor 6 repeats itself", "cable"});
  }
}

TEST(RoomWatch, HugeReadingIsReported) {
  ExpectReported({.event = Fault(Kind::kHuge, 2, 1e-3)}, "sensor-wrong", {2}, {"sensor 2 reads wrong"});
}

TEST(RoomWatch, SilentSensorsAreReportedWithAndWithoutPen) {
  const auto five = [](TruthParameters& truth) {
    for (const int sensor : {0, 2, 3, 5, 7}) Fault(Kind::kStopped, sensor)(truth);
  };
  for (const Pen pen : {Pen::kWaved, Pen::kAway}) {
    SCOPED_TRACE(static_cast<int>(pen));
    ExpectReported({.pen = pen, .event = five}, "sensor-silent", {0, 2, 3, 5, 7},
                   {"sensors 0, 2, 3, 5 and 7 give nothing", "too few", "no force"});
    ExpectReported({.pen = pen, .event = Fault(Kind::kStopped, 4)}, "sensor-silent", {4}, {"sensor 4 gives nothing"});
  }
}

TEST(RoomWatch, SwappedSensorsAreReported) {
  ExpectReported({.event = Fault(Kind::kSwapped, 3, 0, 4)}, "sensors-swapped", {3, 4}, {"sensors 3 and 4 are swapped"});
  ExpectReported({.pen = Pen::kHeld, .event = Fault(Kind::kSwapped, 2, 0, 6)}, "sensors-swapped", {2, 6},
                 {"cables or addresses"});
}

TEST(RoomWatch, SecondPenIsReported) {
  ExpectReported({.pen = Pen::kHeld, .event = SecondPen(0.3)}, "magnet-near", {}, {"another magnet", "take it away"});
  ExpectReported({.event = SecondPen(0.2)}, "magnet-near", {}, {"another magnet", "take it away"});
}

// So near that the tracker may find no pose any more while the pen lies still: that is no misfit of the calibration.
TEST(RoomWatch, SecondPenThatHidesAHeldOneIsReported) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const bool ideal : {false, true}) {
      SCOPED_TRACE(testing::Message() << seed << (ideal ? " ideal" : " room"));
      ExpectReported({.seed = seed, .ideal = ideal, .pen = Pen::kHeld, .idle = true, .event = SecondPen(0.2)},
                     "magnet-near", {}, {"another magnet", "take it away"});
    }
  }
}

TEST(RoomWatch, TurnedBaseIsReportedWithAndWithoutPen) {
  for (const Pen pen : {Pen::kWaved, Pen::kAway}) {
    SCOPED_TRACE(static_cast<int>(pen));
    ExpectReported({.pen = pen, .event = AmbientStep}, "field-changed", {},
                   {"by 60 uT", "carried or turned", "omni calibrate --zero"});
  }
}

TEST(RoomWatch, SteelAddedLaterIsReported) {
  ExpectReported({.event = SteelLater(-0.2)}, "steel-near", {}, {"steel", "omni calibrate"});
}

// The pen itself, laid down beside the base, is reported neither as another magnet nor as another field.
TEST(RoomWatch, MagnetIsReportedWithoutPenUnlessItIsThePenItself) {
  const auto at = [](base::Vec3 moment_Am2) {
    return [=](TruthParameters& truth) {
      truth.effects.room.magnets.push_back(
          {.moment_Am2 = moment_Am2, .from_base_m = {0.3, 0, 0}, .to_base_m = {0.3, 0, 0}});
    };
  };
  const double pen_Am2 = CalibrationOf(Device(), config::RoomTwin(), 5).moment_Am2;
  EXPECT_TRUE(Watch({.pen = Pen::kAway, .event = at({0, pen_Am2, 0})}).kinds.empty());
  EXPECT_EQ(Watch({.pen = Pen::kAway, .event = at({0, 4 * pen_Am2, 0})}).kinds.count("field-uneven"), 1U);
}

TEST(RoomWatch, FindingIsClearedWhenItsCauseIsGone) {
  const auto comes_and_goes = [](TruthParameters& truth) {
    SecondPen(0.3)(truth);
    truth.effects.room.magnets.push_back({.moment_Am2 = {-0.7, -0.5, -0.3},
                                          .from_base_m = {1, 0, 0},
                                          .to_base_m = {0.3, 0, 0},
                                          .leaves_s = kEvent_s + 6,
                                          .arrives_s = kEvent_s + 7});
  };
  const Reported reported = Watch({.event = comes_and_goes, .run_s = 25});
  EXPECT_EQ(reported.kinds, std::set<std::string>{"magnet-near"});
  EXPECT_TRUE(reported.last.empty());
}

class RoomWatchAtPeace : public testing::TestWithParam<std::tuple<bool, Pen>> {};
INSTANTIATE_TEST_SUITE_P(IdealAndRoom, RoomWatchAtPeace,
                         testing::Combine(testing::Bool(), testing::Values(Pen::kWaved, Pen::kAway)));

TEST_P(RoomWatchAtPeace, UndisturbedRoomHasNoFindings) {
  const auto [ideal, pen] = GetParam();
  const Reported reported = Watch({.seed = 7, .ideal = ideal, .pen = pen, .run_s = 30});
  EXPECT_TRUE(reported.kinds.empty()) << *reported.kinds.begin();
}

// Ten seconds after the last one.
// The field about the base is the same one with any pen and without, and follows a change: a base that is turned.
TEST(RoomWatch, FieldAboutTheBaseIsKnownWithAnyPen) {
  constexpr double kError_T = 1.5e-6;
  std::optional<base::Vec3> first_T;
  for (const Pen pen : {Pen::kAway, Pen::kHeld, Pen::kWaved}) {
    SCOPED_TRACE(static_cast<int>(pen));
    const Reported reported = Watch({.pen = pen, .event = AmbientStep});
    ASSERT_TRUE(reported.before_T && reported.after_T);
    if (!first_T) first_T = reported.before_T;
    EXPECT_LT(base::Distance(*reported.before_T, *first_T), kError_T);
    EXPECT_LT(base::Distance(*reported.after_T, *first_T + base::Vec3{40e-6, 30e-6, 33e-6}), kError_T);
  }
}

TEST(RoomWatch, ReportsSoftenedContactsForTenSeconds) {
  room::RoomWatch watch(nullptr);
  tracker::RoomSample sample;
  const auto wait = [&](double seconds, double contact_gain) {
    sample.contact_gain = contact_gain;
    for (int k = 0; k < seconds / 0.1; ++k) {
      sample.scan.t_ns += 100'000'000;
      watch.Add(sample);
    }
    return std::count_if(watch.findings().begin(), watch.findings().end(),
                         [](const room::RoomFinding& finding) { return finding.kind == "contact-softened"; });
  };
  EXPECT_EQ(wait(3, 1), 0);
  EXPECT_EQ(wait(2, 0.2), 1);
  EXPECT_EQ(wait(8, 1), 1);
  EXPECT_EQ(wait(4, 1), 0);
}

}  // namespace test_room_watch
}  // namespace omni::test
