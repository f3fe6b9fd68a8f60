// The stages of the tracker: which of them may change which part of the state, and that none loses what another has
// learnt. The scans are of an eventful minute: fields, magnets, faulty sensors, pens that come and go.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "service/magnetics/dipole.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/stages/hypothesis.h"
#include "service/tracker/stages/publish.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_stages {

using Eigen::Vector3d;

constexpr const char* kStages[] = {"receive", "predict", "explain", "learn", "publish"};

struct Field {
  std::string name;
  std::size_t offset, size;
  std::string writers;  // initials of the stages that may change it
  std::string losers;   // ... and of those that may also set it back to its initial value
};

// Every member of State: one more, or one less, does not compile.
std::vector<Field> Fields() {
  static State s;
  const auto at = [&](const auto& member, const char* name, const char* writers, const char* losers) {
    const auto offset = reinterpret_cast<const char*>(&member) - reinterpret_cast<const char*>(&s);
    return Field{name, static_cast<std::size_t>(offset), sizeof(member), writers, losers};
  };
  auto& [pose, room, search] = s;
  auto& [ever_tracked, warm, bad_scans, filter_t_ns, cold_scan, filter, published] = pose;
  auto& [scans, old_scans, currents, currents_before, repetition, drift, evidence, magnet, mains, doubt, stray, away] =
      room;
  auto& [explained, cold_pause, cold_row, cold_time, pair] = search;
  return {at(ever_tracked, "ever_tracked", "P", ""),
          at(warm, "warm", "LP", "LP"),  // L: a room that cannot exist
          at(bad_scans, "bad_scans", "P", "P"),
          at(filter_t_ns, "filter_t_ns", "P", ""),
          at(cold_scan, "cold_scan", "P", ""),
          at(filter, "filter", "P", ""),
          at(published, "published", "P", ""),
          at(scans, "scans", "r", ""),
          at(old_scans, "old_scans", "r", "r"),
          at(currents, "currents", "r", ""),
          at(currents_before, "currents_before", "r", ""),
          at(repetition, "repetition", "r", ""),
          at(drift, "drift", "rpeL", "L"),
          at(evidence, "evidence", "pL", "L"),
          at(magnet, "magnet", "rpeLP", ""),
          at(mains, "mains", "pL", "L"),
          at(doubt, "doubt", "reL", ""),
          at(stray, "stray", "eL", "L"),
          at(away, "away", "rL", ""),
          at(explained, "explained", "e", "e"),
          at(cold_pause, "cold_pause", "eP", "eP"),
          at(cold_row, "cold_row", "e", "e"),
          at(cold_time, "cold_time", "e", "e"),
          at(pair, "pair", "eP", "")};
}

constexpr char kInitials[] = "rpeLP";

// Compares a state before and after a stage, field by field.
class Ledger {
 public:
  void Stage(std::size_t stage, const State& before, const State& after) {
    static const State initial{};
    for (const Field& field : fields_) {
      const auto part = [&](const State& s) { return reinterpret_cast<const char*>(&s) + field.offset; };
      if (std::memcmp(part(before), part(after), field.size) == 0) continue;
      written_[field.name].insert(kInitials[stage]);
      if (field.writers.find(kInitials[stage]) == std::string::npos) Complain(field, stage, " changes ");
      if (std::memcmp(part(initial), part(after), field.size) != 0) continue;
      if (field.losers.find(kInitials[stage]) == std::string::npos) Complain(field, stage, " loses ");
    }
  }
  const std::set<std::string>& complaints() const { return complaints_; }
  std::set<std::string> Unwritten() const {
    std::set<std::string> unwritten;
    for (const Field& field : fields_) {
      const auto found = written_.find(field.name);
      for (const char initial : field.writers) {
        if (found == written_.end() || !found->second.contains(initial)) unwritten.insert(field.name + ":" + initial);
      }
    }
    return unwritten;
  }

 private:
  void Complain(const Field& field, std::size_t stage, const char* does) {
    complaints_.insert(kStages[stage] + std::string(does) + field.name);
  }
  std::vector<Field> fields_ = Fields();
  std::map<std::string, std::set<char>> written_;
  std::set<std::string> complaints_;
};

// A minute in which everything happens that the tracker has a hypothesis for.
class EventfulMinute {
 public:
  explicit EventfulMinute(const Config& config, std::uint64_t seed) : model_(config.model), rng_(seed) {}

  static constexpr int kScans = 34'000;

  base::HallScan Next() {
    const int n = n_++;
    const auto between = [&](double from_s, double to_s) { return n >= 1e3 * from_s && n < 1e3 * to_s; };
    if (!between(20, 20.03)) t_ns_ += 1'000'000;  // the clock stops
    const double t_s = 1e-3 * n;
    const bool rests = between(5, 8);
    if (!rests) angle_s_ += 1e-3;
    const double a = angle_s_;
    Pose pose;
    pose.position_base_m = {0.02 * std::cos(4 * a), 0.02 * std::sin(4 * a), 0.06 + 0.01 * std::sin(3 * a)};
    pose.axis_base = Vector3d(0.4 * std::sin(2 * a), 0.4 * std::cos(2.5 * a), -1).normalized();
    const bool gone = between(0, 1.5) || between(16, 18) || between(28, 30);
    if (gone) pose = {{0, 0, 1e3}, Vector3d::UnitZ()};
    base::HallScan scan = support::MakeScan(model_, pose, t_ns_, rng_, {1, {}});
    scan.sequence = static_cast<std::uint64_t>(n);
    const double mains_T = between(3, 5) ? 3e-6 * std::sin(2 * std::numbers::pi * 50 * t_s) : 0;
    Vector3d field_T = mains_T * Vector3d::UnitX();
    if (n >= 2500) field_T += Vector3d(8e-6, -5e-6, 4e-6);              // it jumps
    if (between(24, 25)) field_T += Vector3d(4e-4, 0, 0) * (t_s - 24);  // more than any room has
    const bool beside = between(9, 14) || between(29, 34);  // another magnet, the second time from the start
    const Vector3d there_m = Vector3d(0.25, 0.05, 0) + 0.2 * std::max(0.0, 10 - t_s) * Vector3d::UnitX();
    for (std::size_t i = 0; i < kSensors; ++i) {
      Vector3d at_T = field_T;
      const auto& places = model_.places[0].position_base_m;
      const Vector3d sensor_m(places[0][i], places[1][i], places[2][i]);
      if (beside) at_T += magnetics::DipoleField(model_.moment_Am2 * Vector3d::UnitY(), sensor_m - there_m);
      support::AddField(model_, i, at_T, scan);
    }
    if (between(18, 20)) Scale(0.85, scan);                            // another pen
    if (between(21, 22)) scan.field_sensor_T[3] = {1e-3, 1e-3, 1e-3};  // a broken sensor
    if (between(22.5, 23)) scan.field_sensor_T[5] = stuck_T_;          // one that repeats itself
    if (between(26, 26.5))
      for (auto& B : scan.field_sensor_T) B = {3e-4, 1e-4, -2e-4};  // no pose
    stuck_T_ = scan.field_sensor_T[5];
    return scan;
  }

 private:
  void Scale(double gain, base::HallScan& scan) {
    for (base::Vec3& B : scan.field_sensor_T) B = gain * B;
  }
  Model model_;
  support::Rng rng_;
  int n_ = 0;
  std::int64_t t_ns_ = 1'000'000'000;
  double angle_s_ = 0;
  base::Vec3 stuck_T_;
};

// After each stage.
using Tamper = std::function<void(std::size_t stage, State& state)>;

// The stages one by one, as Update calls them, until there is a complaint. Returns the hypotheses that explained a
// scan.
std::set<std::string> RunStages(const Config& config, const Tamper& tamper, Ledger& ledger) {
  std::set<std::string> hypotheses;
  EventfulMinute minute(config, 7);
  auto state = std::make_unique<State>(), before = std::make_unique<State>(), whole = std::make_unique<State>();
  base::ToolState tool;
  const auto end = [&](std::size_t stage) {
    if (tamper) tamper(stage, *state);
    ledger.Stage(stage, *before, *state);
    *before = *state;
  };
  for (int n = 0; n < EventfulMinute::kScans && ledger.complaints().empty(); ++n) {
    const base::HallScan scan = minute.Next();
    if (IsRepeated(config, scan, state->room)) {
      end(0);
      PublishRepeated(config, scan, *state);
    } else {
      const Received received = Receive(config, scan, state->room);
      end(0);
      Predicted predicted = PredictTo(config, received, false, *state);
      end(1);
      Explanation explanation = Explain(config, received, predicted, *state);
      end(2);
      const Observation observation{config, received, predicted, explanation};
      if (!Learn(observation, *state)) explanation.outcome.good = false;
      end(3);
      Publish(observation, predicted.filter, *state);
    }
    end(4);
    Update(config, scan, *whole, tool);
    const base::ToolState& published = state->pose.published;
    const bool same = published.position_base_m == tool.position_base_m && published.limits == tool.limits;
    if (!tamper && !same) ADD_FAILURE() << "Update runs other stages, scan " << n;
    if (tool.hypothesis != nullptr) hypotheses.insert(tool.hypothesis);
  }
  return hypotheses;
}

class TrackerStages : public testing::Test {
 protected:
  const Config config = MakeConfig(magnetics::NominalCalibration(support::NominalDevice()));
  Ledger ledger;
};

TEST_F(TrackerStages, EachChangesOnlyItsPartOfTheStateAndLosesNothing) {
  const std::set<std::string> hypotheses = RunStages(config, {}, ledger);
  EXPECT_EQ(ledger.complaints(), std::set<std::string>{});
  EXPECT_EQ(ledger.Unwritten(), std::set<std::string>{}) << "the scans say nothing about these";
  // What these scans do not need.
  const std::set<std::string> absent{"magnet arrived", "another pen", "magnet loosened", "one sensor wrong, any field",
                                     "poor calibration, any field"};
  for (const auto& rows : {WarmHypotheses(), ColdHypotheses(), SlowHypotheses()}) {
    for (const Hypothesis& row : rows) EXPECT_NE(hypotheses.contains(row.name), absent.contains(row.name)) << row.name;
  }
}

// A stage that throws away what another has learnt is found out, whatever it is.
TEST_F(TrackerStages, LostFieldIsNoticed) {
  for (const Field& field : Fields()) {
    const std::size_t stage = field.losers.find('P') == std::string::npos ? 4 : 0;
    ledger = {};
    int calls = 0;
    RunStages(
        config,
        [&](std::size_t now, State& state) {
          static const State initial{};
          if (now != stage || ++calls < 2000) return;
          std::memcpy(reinterpret_cast<char*>(&state) + field.offset,
                      reinterpret_cast<const char*>(&initial) + field.offset, field.size);
        },
        ledger);
    EXPECT_FALSE(ledger.complaints().empty()) << field.name;
  }
}

}  // namespace test_tracker_stages
}  // namespace omni::tracker
