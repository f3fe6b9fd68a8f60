#include "service/tools/calibrate/calibrate_session.h"

#include <cmath>
#include <string>

#include "service/base/eigen.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::tools {
namespace {

constexpr int kRestScans = 500;
constexpr double kRest_m = 1e-3;  // a hand that holds still
constexpr int kSwingScans = 10'000;
constexpr int kLostScans = 10'000;    // as many: the pen is not near enough, or the base is not as it was
constexpr double kMostMissed = 0.01;  // of all scans: with more, this computer is to blame before the pen
constexpr int kMeanScans = 100;       // averaged per pose: reduces noise and preserves p + d u = c, which is linear

std::string Seconds(int scans) {
  return std::to_string(static_cast<int>(std::lround(scans * base::kTickPeriod_s))) + " s";
}

// Of one scan in a mean.
void AddShare(const base::Vec3& v, base::Vec3& mean) {
  mean = base::FromEigen(base::ToEigen(mean) + base::ToEigen(v) / kMeanScans);
}

}  // namespace

TipSession::TipSession(const base::Calibration& calibration, double drawn_m)
    : config_(tracker::MakeConfig(calibration)), drawn_m_(drawn_m), expected_error_m_(calibration.expected_error_m) {}

void TipSession::CountMissed(const base::HallScan& scan) {
  if (scans_ > 0 && scan.sequence > last_sequence_) missed_scans_ += scan.sequence - last_sequence_ - 1;
  last_sequence_ = scan.sequence;
  ++scans_;
}

base::CoilCurrents TipSession::Add(const base::HallScan& scan) {
  CountMissed(scan);
  base::ToolState tool;
  tracker::Update(config_, scan, state_, tool);
  if (step_ == TipStep::kRest) {
    AddRest(tool);
  } else if (step_ == TipStep::kSwing) {
    AddSwing(tool);
  }
  return {};
}

void TipSession::AddRest(const base::ToolState& tool) {
  if (tool.status != base::TrackingStatus::kTracking) {
    rest_scans_ = 0;
    return;
  }
  if (rest_scans_ == 0 || !(base::Distance(tool.position_base_m, rested_base_m_) <= kRest_m)) {
    rested_base_m_ = tool.position_base_m;
    rest_scans_ = 0;
  }
  if (++rest_scans_ >= kRestScans) step_ = TipStep::kSwing;
}

void TipSession::AddSwing(const base::ToolState& tool) {
  if (tool.status == base::TrackingStatus::kTracking) {
    AddShare(tool.position_base_m, mean_.position_base_m);
    AddShare(tool.axis_base, mean_.axis_base);
    if (++swing_scans_ % kMeanScans == 0) {
      poses_.push_back(mean_);
      mean_ = {};
    }
  } else {
    ++lost_scans_;
  }
  if (swing_scans_ >= kSwingScans || lost_scans_ >= kLostScans) step_ = TipStep::kDone;
}

double TipSession::progress() const {
  switch (step_) {
    case TipStep::kRest:
      return static_cast<double>(rest_scans_) / kRestScans;
    case TipStep::kSwing:
      return static_cast<double>(swing_scans_) / kSwingScans;
    case TipStep::kDone:
      break;
  }
  return 1;
}

std::string TipSession::Instruction() const {
  switch (step_) {
    case TipStep::kRest:
      return "1/2  Rest the pen's tip in a dimple beside the base, at the height of its ball, and hold it still.";
    case TipStep::kSwing:
      return "2/2  Leave the tip there and tilt the pen in all directions, as far as it goes, for " +
             Seconds(kSwingScans) + ".";
    case TipStep::kDone:
      break;
  }
  return "Computing.";
}

std::string TipSession::Hint() const {
  if (step_ != TipStep::kRest) return {};
  return "No pen was found at rest: bring it within a hand's breadth of the ball and hold it still for half a second.";
}

base::Result<calibration::Tip> TipSession::Finish() const {
  if (swing_scans_ < kSwingScans) {
    return base::Error{"tip not measured: the pen was tracked for " + Seconds(swing_scans_) + " of the " +
                       Seconds(kSwingScans) +
                       " needed, and lost as long: stay within a hand's breadth of the ball, "
                       "move other magnets and steel away"};
  }
  auto tip = calibration::FindTip(poses_, drawn_m_, expected_error_m_);
  const double missed = static_cast<double>(missed_scans_) / static_cast<double>(scans_ + missed_scans_);
  if (tip.ok() || missed <= kMostMissed) return tip;
  return base::Error{"tip not measured: this computer was busy and missed " +
                     std::to_string(std::lround(100 * missed)) +
                     " % of the base's samples; close other programs and measure it again (" + tip.error() + ")"};
}

}  // namespace omni::tools
