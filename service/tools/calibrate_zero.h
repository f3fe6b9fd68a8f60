// omni calibrate --zero: what the sensors read without a pen, measured again in two seconds. For a base that was
// carried or turned, a laptop that was opened, sensors that drifted: everything else of its calibration stays.
#pragma once

#include <array>

#include "service/base/calibration.h"
#include "service/base/limits.h"
#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/tools/guided_session.h"

namespace omni::tools {

// `before` with the new background.
struct Zeroed {
  base::Calibration calibration;
  double uniform_T = 0;  // by which the field around the base has changed
  double own_T = 0;      // the greatest change of one sensor beside it
};

class ZeroSession final : public GuidedSession {
 public:
  explicit ZeroSession(const base::Calibration& before) : before_(before) {}

  base::CoilCurrents Add(const base::HallScan& scan) override;  // coils at zero
  bool done() const override;
  int step_number() const override { return 0; }
  double progress() const override;
  std::string Instruction() const override;
  std::string Hint() const override { return {}; }

  // Refuses, with the reason, what is no background: a pen or magnet near, readings that move or do not come.
  base::Result<Zeroed> Finish() const;

 private:
  static constexpr int kBlocks = 8;  // of a quarter of a second: whole periods of any mains
  struct Sum {
    std::array<base::Vec3, kBlocks> block_sensor_T;
    int fresh = 0;
  };

  base::Calibration before_;
  int scans_ = 0;
  bool bad_ = false;  // saturated or no number
  std::array<Sum, base::kSensorCount> sums_{};
};

}  // namespace omni::tools
