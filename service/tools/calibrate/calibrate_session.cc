#include "service/tools/calibrate/calibrate_session.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

#include "service/base/eigen.h"
#include "service/base/limits.h"
#include "service/calibration/checks/checks.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/solve/gap.h"

namespace omni::tools {
namespace {

constexpr int kClearScans = 100;      // without a strong field in a row
constexpr double kClear_T = 1.5e-4;   // the earth's field and some iron nearby
constexpr double kReach_m = 0.16;     // further away a pose carries little information on the sensors
constexpr double kTouchGap_m = 0.01;  // an uncalibrated pose is good to some millimetres
constexpr calibration::WindowOptions kWindow{};

}  // namespace

CalibrationSession::CalibrationSession(const base::DeviceGeometry& device, const SessionOptions& options)
    : device_(device),
      options_(options),
      nominal_(magnetics::NominalCalibration(device)),
      plan_(calibration::MakeSweep(options.sweep)),
      window_(kWindow, device.sensor_noise_T) {}

base::CoilCurrents CalibrationSession::Add(const base::HallScan& scan) {
  if (step_ == CalibrationStep::kClear) AddClear(scan);
  if (step_ == CalibrationStep::kSweep) return AddSweep(scan);
  if (step_ != CalibrationStep::kWave && step_ != CalibrationStep::kTouch) return {};
  const auto window = window_.Add(scan);
  if (!window) return {};
  if (step_ == CalibrationStep::kWave) {
    AddWave(*window);
  } else {
    AddTouch(*window);
  }
  return {};
}

void CalibrationSession::AddClear(const base::HallScan& scan) {
  const auto& fields = scan.field_sensor_T;
  const auto strongest = std::max_element(fields.begin(), fields.end(),
                                          [](const base::Vec3& a, const base::Vec3& b) { return Norm(a) < Norm(b); });
  strongest_ = static_cast<int>(strongest - fields.begin());
  strongest_T_ = Norm(*strongest);
  clear_scans_ = strongest_T_ <= kClear_T ? clear_scans_ + 1 : 0;
  if (clear_scans_ >= kClearScans) step_ = CalibrationStep::kSweep;
}

base::CoilCurrents CalibrationSession::AddSweep(const base::HallScan& scan) {
  const calibration::SweepStep& step = plan_[sweep_step_];
  sweep_.Add(scan, step.rest);
  ++sweep_scans_all_;
  if (++sweep_scans_ >= step.scans) {
    sweep_scans_ = 0;
    ++sweep_step_;
  }
  if (sweep_step_ < plan_.size()) return {plan_[sweep_step_].current_A};
  FinishSweep();
  return {};
}

void CalibrationSession::FinishSweep() {
  step_ = CalibrationStep::kDone;
  const auto responses = sweep_.Finish();
  if (!responses.ok()) {
    problem_ = responses.error();
    return;
  }
  if (const std::string why = calibration::ResponsesProblem(nominal_, *responses); !why.empty()) {
    problem_ = "calibration refused: " + why;
    return;
  }
  recording_.responses = *responses;
  base::Calibration measured = nominal_;
  for (std::size_t i = 0; i < responses->size(); ++i) {
    measured.sensors[i].background_sensor_T = (*responses)[i].background_sensor_T;
    measured.sensors[i].current_map_T_A = (*responses)[i].map_sensor_T_A;
  }
  auto cold = calibration::ColdStart::Make(measured, {});
  if (!cold.ok()) {
    problem_ = cold.error();
    return;
  }
  cold_ = std::move(*cold);
  step_ = CalibrationStep::kWave;
}

// In reach, or not found.
calibration::ColdPose CalibrationSession::RoughPose(const calibration::Sample& sample) const {
  calibration::ColdPose pose = cold_->FindPose(sample);
  pose.found = pose.found && pose.position_base_m.norm() <= kReach_m;
  return pose;
}

void CalibrationSession::AddWave(const calibration::WindowResult& window) {
  const calibration::ColdPose pose = RoughPose(window.sample);
  if (!pose.found) return;
  coverage_.Add({pose.position_base_m.x(), pose.position_base_m.y(), pose.position_base_m.z()});
  recording_.samples.push_back(window.sample);
  if (progress() >= 1) step_ = CalibrationStep::kTouch;
}

void CalibrationSession::AddTouch(const calibration::WindowResult& window) {
  const auto touch = picker_.Add(window);
  if (!touch) return;
  const calibration::ColdPose pose = RoughPose(*touch);
  if (!pose.found) return;
  const double gap_m =
      tracker::CylinderGap({pose.position_base_m.x(), pose.position_base_m.y(), pose.position_base_m.z()},
                           {pose.axis_base.x(), pose.axis_base.y(), pose.axis_base.z()}, device_.magnet.radius_m,
                           device_.magnet.half_height_m, device_.hull_radius_m);
  if (!(std::abs(gap_m) <= kTouchGap_m)) return;  // a rest in the air
  recording_.samples.push_back(*touch);
  if (++touches_ >= options_.touches) step_ = CalibrationStep::kDone;
}

double CalibrationSession::progress() const {
  const double window_s = kWindow.scans * base::kTickPeriod_s;
  switch (step_) {
    case CalibrationStep::kClear:
      return static_cast<double>(clear_scans_) / kClearScans;
    case CalibrationStep::kSweep: {
      int scans = 0;
      for (const calibration::SweepStep& step : plan_) scans += step.scans;
      return static_cast<double>(sweep_scans_all_) / scans;
    }
    case CalibrationStep::kWave:
      return std::min(1.0, static_cast<double>(recording_.samples.size()) * window_s / options_.wave_s);
    case CalibrationStep::kTouch:
      return static_cast<double>(touches_) / options_.touches;
    case CalibrationStep::kDone:
      break;
  }
  return 1;
}

std::string CalibrationSession::Instruction() const { return StepText(step_, options_); }

std::string CalibrationSession::Hint() const {
  switch (step_) {
    case CalibrationStep::kClear: {
      char text[160];
      std::snprintf(text, sizeof text,
                    "Sensor %d still reads %.0f uT (limit %.0f uT): move the pen, phones and loudspeakers away.",
                    strongest_, 1e6 * strongest_T_, 1e6 * kClear_T);
      return text;
    }
    case CalibrationStep::kWave:
      return "No pen was found: wave it within a hand's breadth of the hull.";
    case CalibrationStep::kTouch:
      return "No touch was found: put the pen's end on the hull and hold it still for a third of a second.";
    case CalibrationStep::kSweep:
    case CalibrationStep::kDone:
      break;
  }
  return {};
}

base::Result<calibration::Outcome> CalibrationSession::Finish() const {
  if (!problem_.empty()) return base::Error{problem_};
  return calibration::SelfCalibrate(nominal_, device_.coils, recording_);
}

namespace {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr int kSettleScans = 300;  // at first: eddy currents in the core die out
constexpr int kBlockScans = 250;
constexpr int kFreshMin = calibration::kZeroBlocks * kBlockScans / 10;

}  // namespace

base::CoilCurrents ZeroSession::Add(const base::HallScan& scan) {
  const int at = scans_++ - kSettleScans;
  if (at < 0 || at >= calibration::kZeroBlocks * kBlockScans) return {};
  for (std::size_t i = 0; i < readings_.size(); ++i) {
    const Eigen::Map<const RowMajor3d> map(before_.sensors[i].current_map_T_A.data());
    const Vector3d read =
        base::ToEigen(scan.field_sensor_T[i]) - map * Eigen::Map<const Vector3d>(scan.coil_current_A.data());
    base::Vec3& sum = readings_[i][static_cast<std::size_t>(at / kBlockScans)];
    sum = base::FromEigen(base::ToEigen(sum) + read / kBlockScans);
    fresh_[i] += static_cast<int>((scan.fresh_mask >> i) & 1U);
    bad_ = bad_ || !read.allFinite() || ((scan.saturated_mask >> (3 * i)) & 7U) != 0;
  }
  return {};
}

bool ZeroSession::done() const { return scans_ >= kSettleScans + calibration::kZeroBlocks * kBlockScans; }

double ZeroSession::progress() const {
  return std::clamp(static_cast<double>(scans_) / (kSettleScans + calibration::kZeroBlocks * kBlockScans), 0.0, 1.0);
}

std::string ZeroSession::Instruction() const {
  return "Move the pen and other magnets a metre away, and do not touch the base for two seconds.";
}

base::Result<calibration::Zeroed> ZeroSession::Finish() const {
  const auto refused = [](const std::string& why) { return base::Error{"not zeroed: " + why}; };
  if (!done()) return refused("the readings ended before two seconds; start again");
  if (bad_) return refused("a sensor is saturated or has invalid readings: move the pen and other magnets away");
  const auto silent = std::find_if(fresh_.begin(), fresh_.end(), [](int fresh) { return fresh < kFreshMin; });
  if (silent != fresh_.end()) {
    return refused("sensor " + std::to_string(silent - fresh_.begin()) +
                   " sends nothing new: run omni device selftest");
  }
  return calibration::Rezero(before_, readings_);
}

}  // namespace omni::tools
