// Sessions that guide a person through a calibration, or a part of it, and what `omni calibrate` shows of them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/force_limit.h"
#include "service/base/hall_scan.h"
#include "service/base/limits.h"
#include "service/base/result.h"
#include "service/calibration/checks/coil_sweep.h"
#include "service/calibration/checks/tip.h"
#include "service/calibration/checks/zero.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/calibration/fit/start.h"
#include "service/calibration/fit/window.h"
#include "service/calibration/types.h"
#include "service/device/transport.h"
#include "service/tracker/tracker.h"

namespace omni::tools {

// Guides a person through steps at a base: consumes its scans and returns the currents to set.
class GuidedSession {
 public:
  virtual ~GuidedSession() = default;

  // Every scan in turn; returns the currents to set next.
  virtual base::CoilCurrents Add(const base::HallScan& scan) = 0;

  virtual bool done() const = 0;
  virtual int step_number() const = 0;          // changes when the instruction changes
  virtual double progress() const = 0;          // of this step, 0 to 1
  virtual std::string Instruction() const = 0;  // what to do in this step, one line
  virtual std::string Hint() const = 0;         // what holds this step up
};

// Runs a session on a base: feeds it scans and sets the currents that it requests.

// Until the session is done, `observer` after every scan; the coils are at zero then, and after every error. The
// session begins once the base is armed. Errors: the base is gone, silent for a second, not armed within 5 s or in a
// fault; a signal (EndSignals); a step without progress for two minutes; a recording or virtual run that ends early.
base::Status RunSession(device::Transport& transport, GuidedSession& session, const std::function<void()>& observer);

// One calibration, scan by scan: sweep the coils without the pen, wave the pen, touch the hull. Knows no device, no
// terminal and no clock, so that the command, the benchmark and the tests drive the same code.
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

// omni calibrate --tip: where the pen's tip is. The tip rests in a dimple, the pen is swung about it; everything else
// of a calibration stays.
enum class TipStep { kRest, kSwing, kDone };

class TipSession final : public GuidedSession {
 public:
  // `drawn_m`: the nominal tip offset.
  TipSession(const base::Calibration& calibration, double drawn_m);

  base::CoilCurrents Add(const base::HallScan& scan) override;  // coils at zero
  TipStep step() const { return step_; }
  bool done() const override { return step_ == TipStep::kDone; }
  int step_number() const override { return static_cast<int>(step_); }
  double progress() const override;
  std::string Instruction() const override;
  std::string Hint() const override;

  // Error, with the reason, if the pen was lost or calibration::FindTip fails.
  base::Result<calibration::Tip> Finish() const;

 private:
  void CountMissed(const base::HallScan& scan);
  void AddRest(const base::ToolState& tool);
  void AddSwing(const base::ToolState& tool);

  tracker::Config config_;
  tracker::State state_;
  double drawn_m_;
  double expected_error_m_;
  TipStep step_ = TipStep::kRest;
  base::Vec3 rested_base_m_;                    // where the magnet was when it came to rest
  std::uint64_t scans_ = 0, missed_scans_ = 0;  // seen, and not seen between them
  std::uint64_t last_sequence_ = 0;
  int rest_scans_ = 0;
  int swing_scans_ = 0;          // tracked ...
  int lost_scans_ = 0;           // ... and not, in that step
  calibration::PivotPose mean_;  // so far
  std::vector<calibration::PivotPose> poses_;
};

// omni calibrate --zero: measures again in two seconds what the sensors read without a pen. For a base that was
// carried or turned, a laptop that was opened, sensors that drifted: everything else of its calibration stays.
class ZeroSession final : public GuidedSession {
 public:
  explicit ZeroSession(const base::Calibration& before) : before_(before) {}

  base::CoilCurrents Add(const base::HallScan& scan) override;  // coils at zero
  bool done() const override;
  int step_number() const override { return 0; }
  double progress() const override;
  std::string Instruction() const override;
  std::string Hint() const override { return {}; }

  // Error, with the reason, if these are not background readings: a pen or magnet is near, readings change or are
  // missing.
  base::Result<calibration::Zeroed> Finish() const;

 private:
  base::Calibration before_;
  int scans_ = 0;
  bool bad_ = false;  // saturated or no number
  std::array<calibration::ZeroReadings, base::kSensorCount> readings_{};
  std::array<int, base::kSensorCount> fresh_{};  // samples
};

// What `omni calibrate` shows: steps, a progress bar, the hemisphere's coverage, the result.

// Instruction for the current step, one line.
std::string StepText(CalibrationStep step, const SessionOptions& options);
// The upper hemisphere from above, the rim outside: one character per cell, '.' where the pen has not been, in one line
// per band from the top down.
std::string CoverageText(const calibration::Coverage& coverage);
// Residuals, parameters that were not fixed, and one word for the overall quality.
std::string ReportText(const calibration::Report& report);
// What was measured again, one line.
std::string ZeroText(const calibration::Zeroed& zeroed);
std::string TipText(const calibration::Tip& tip, double drawn_m);
// "excellent", "good", "fair" or "poor", by the error that the calibration leaves.
std::string QualityWord(double expected_error_m);

}  // namespace omni::tools
