// omni calibrate --tip: where the pen's tip is. The tip rests in a dimple, the pen is swung about it; everything else
// of a calibration stays.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/calibration.h"
#include "service/base/result.h"
#include "service/calibration/checks/tip.h"
#include "service/tools/calibrate/guided_session.h"
#include "service/tracker/tracker.h"

namespace omni::tools {

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

}  // namespace omni::tools
