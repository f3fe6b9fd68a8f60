// omni calibrate --zero: measures again in two seconds what the sensors read without a pen. For a base that was
// carried or turned, a laptop that was opened, sensors that drifted: everything else of its calibration stays.
#pragma once

#include <array>

#include "service/base/calibration.h"
#include "service/base/limits.h"
#include "service/base/result.h"
#include "service/calibration/checks/zero.h"
#include "service/tools/calibrate/guided_session.h"

namespace omni::tools {

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

}  // namespace omni::tools
