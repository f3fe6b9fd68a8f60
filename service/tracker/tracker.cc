#include "service/tracker/tracker.h"

#include <algorithm>

#include "service/magnetics/nominal.h"
#include "service/tracker/kernel/steel.h"
#include "service/tracker/stages/publish.h"

namespace omni::tracker {
namespace {

constexpr double kCalibratedError = 0.01;  // of the model: beyond, something other than the calibration is wrong
constexpr double kCalibratedCoils = 6e-4;  // of the coils' field, whose maps were measured
constexpr double kDrawnError = 0.05;       // of an uncalibrated base: 1 mm, 1.5 %, 1.15 degrees
constexpr double kDrawnLowerBelow = 0.6;   // of its chi2 per degree of freedom: at one place it is lower by chance
constexpr double kDrawnPlace_m = 0.03;     // a pen at rest wanders by 10 mm where its place is known poorly
constexpr double kDrawnSigma_m = 0.05;     // in any ambient field a pen that points straight down is known to 20 mm
constexpr double kDrawnSame_rad = 2, kDrawnSame_s = 1e3;
constexpr double kTypicalDistance_m = 0.15;  // from the pen to a sensor
constexpr double kModelErrorMin = 1e-3;      // of a calibrated base, once its readings have been evaluated

// A position error dp at the distance d looks like 3 dp / d of a dipole's field; never less than the nominal share,
// which a calibration cannot see in itself (sensors that are not straight).   docs/theory/tracking.md (3.1)
double ModelErrorOf(const base::Calibration& calibration, double nominal) {
  if (!(calibration.expected_error_m > 0)) return nominal;
  return std::max(nominal, 3 * calibration.expected_error_m / kTypicalDistance_m);
}

}  // namespace

Config MakeConfig(const base::Calibration& calibration) {
  Config config;
  config.model = MakeModel(calibration);
  if (!SteelMatters(config.model)) config.model.steel.strength = 0;
  config.trust.coil_error_relative = kCalibratedCoils;
  config.trust.model_error_relative = kModelErrorMin;
  config.doubt.model_error_start = std::min(ModelErrorOf(calibration, Trust{}.model_error_relative), kDrawnError);
  config.drift.core_kept_A = calibration.core_kept_A;
  config.doubt.model_error_max = std::max(kCalibratedError, config.doubt.model_error_start);
  return config;
}

// Nominal geometry: the readings show how accurately it is built.
Config MakeConfig(const base::DeviceGeometry& device) {
  Config config = MakeConfig(magnetics::NominalCalibration(device));
  config.trust = Trust{};
  config.doubt.model_error_max = config.doubt.cold_error_max = kDrawnError;
  config.doubt.lower_below = kDrawnLowerBelow;
  config.doubt.cold_sigma_max_m = kDrawnSigma_m;
  config.doubt.place_m = kDrawnPlace_m;
  // A sensor that is turned or out of place has the same error over most of the reach, for as long as it is there.
  config.drift.same_error_m = kTypicalDistance_m;
  config.drift.same_error_rad = kDrawnSame_rad;
  config.drift.same_error_s = kDrawnSame_s;
  config.stray.enabled = false;    // its own errors would pass for a magnet ...
  config.magnets.enabled = false;  // ... or for another pen
  return config;
}

void Update(const Config& config, const base::HallScan& scan, State& state, base::ToolState& tool,
            bool pushed) noexcept {
  if (!IsRepeated(config, scan, state.room)) {
    const Received received = Receive(config, scan, state.room);
    Predicted predicted = PredictTo(config, received, pushed, state);
    Explanation explanation = Explain(config, received, predicted, state);
    const Observation observation{config, received, predicted, explanation};
    if (!Learn(observation, state)) explanation.outcome.good = false;
    Publish(observation, predicted.filter, state);
  } else {
    PublishRepeated(config, scan, state);
  }
  tool = state.pose.published;
}

}  // namespace omni::tracker
