// One calibration, scan by scan: sweep the coils without the pen, wave the pen, touch the hull. Knows no device, no
// terminal and no clock, so that the command, the benchmark and the tests drive the same code.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "service/base/actuation_types.h"
#include "service/base/device_geometry.h"
#include "service/base/hall_scan.h"
#include "service/base/result.h"
#include "service/calibration/checks/coil_sweep.h"
#include "service/calibration/checks/coverage.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/calibration/fit/start.h"
#include "service/calibration/fit/touches.h"
#include "service/calibration/fit/window.h"
#include "service/tools/calibrate/guided_session.h"

namespace omni::tools {

enum class CalibrationStep { kClear, kSweep, kWave, kTouch, kDone };

struct SessionOptions {
  double wave_s = 20;
  int touches = 100;
  calibration::SweepPlan sweep;
};

class CalibrationSession final : public GuidedSession {
 public:
  CalibrationSession(const base::DeviceGeometry& device, const SessionOptions& options);

  // Every scan in turn; returns the currents to set next.
  base::CoilCurrents Add(const base::HallScan& scan) override;

  CalibrationStep step() const { return step_; }
  bool done() const override { return step_ == CalibrationStep::kDone; }
  int step_number() const override { return static_cast<int>(step_); }
  double progress() const override;
  std::string Instruction() const override;
  const std::string& problem() const { return problem_; }  // why it ended early; empty: it did not
  std::string Hint() const override;
  const SessionOptions& options() const { return options_; }
  const calibration::Coverage& coverage() const { return coverage_; }
  const calibration::Recording& recording() const { return recording_; }

  // Step kDone: the adjustment.
  base::Result<calibration::Outcome> Finish() const;

 private:
  void AddClear(const base::HallScan& scan);
  base::CoilCurrents AddSweep(const base::HallScan& scan);
  void FinishSweep();
  calibration::ColdPose RoughPose(const calibration::Sample& sample) const;
  void AddWave(const calibration::WindowResult& window);
  void AddTouch(const calibration::WindowResult& window);

  base::DeviceGeometry device_;
  SessionOptions options_;
  base::Calibration nominal_;
  std::optional<calibration::ColdStart> cold_;  // nominal geometry with measured maps and background, after the sweep
  std::vector<calibration::SweepStep> plan_;
  calibration::CoilSweep sweep_;
  calibration::Window window_;
  calibration::TouchPicker picker_;
  calibration::Coverage coverage_;
  calibration::Recording recording_;
  CalibrationStep step_ = CalibrationStep::kClear;
  std::string problem_;
  int clear_scans_ = 0;
  int strongest_ = 0;  // sensor, and its last reading while the pen had to be away
  double strongest_T_ = 0;
  std::size_t sweep_step_ = 0;
  int sweep_scans_ = 0;  // of this sweep step
  int sweep_scans_all_ = 0;
  int touches_ = 0;
};

}  // namespace omni::tools
