#include "service/tools/calibrate/calibrate_twin.h"

#include "service/sim/fields/imperfections.h"
#include "service/sim/fields/random.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_device.h"
#include "service/tools/calibrate/calibrate_hand.h"

namespace omni::tools {
namespace {

constexpr double kDurationMax_s = 300;  // the scripted hand finishes long before
constexpr double kClockStart_s = 1;     // of the twin's stamps

}  // namespace

base::Result<TwinCalibration> CalibrateTwin(const base::DeviceGeometry& device, std::uint64_t seed,
                                            const base::TruthParameters& truth, const SessionOptions& options,
                                            const SessionObserver& observer) {
  // A little more than required: some windows are too jerky to count, and some touches too short.
  const CalibratingHand hand{
      .wave_s = 1.1 * options.wave_s + 1, .touches = options.touches * 4 / 3 + 5, .seed = seed + 1};
  const sim::TwinOptions twin{
      .seed = seed, .script = MakeCalibratingHand(WithHeldTip(device, seed, truth), hand), .truth = truth};
  const auto transport = sim::MakeVirtualTwin(device, twin, kDurationMax_s);
  CalibrationSession session(device, options);
  const auto seen = [&] {
    if (observer) observer(session);
  };
  if (const base::Status ran = RunSession(*transport, session, seen); !ran.ok()) return base::Error{ran.error()};
  auto outcome = session.Finish();
  if (!outcome.ok()) return base::Error{outcome.error()};
  const auto& samples = session.recording().samples;
  return TwinCalibration{std::move(*outcome), 0.5 * (samples.front().t_s + samples.back().t_s) - kClockStart_s};
}

base::DeviceGeometry WithHeldTip(const base::DeviceGeometry& device, std::uint64_t seed,
                                 const base::TruthParameters& truth) {
  sim::Random random(seed);
  base::DeviceGeometry held = device;
  held.magnet.tip_offset_m =
      sim::TrueSizes(device, sim::DrawImperfections(truth.imperfections, random)).magnet.tip_offset_m;
  return held;
}

}  // namespace omni::tools
