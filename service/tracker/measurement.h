// From a scan to whitened readings of the tool's field alone.
#pragma once

#include <array>
#include <cstdint>

#include "service/base/hall_scan.h"
#include "service/tracker/linearise.h"
#include "service/tracker/model.h"

namespace omni::tracker {

// How far readings and currents are to be trusted. docs/theory/tracking.md (3), (4)
struct Trust {
  double model_error_relative = 2e-3;    // of the tool's field: calibration of gain, alignment, position, moment
  double coil_error_relative = 2.5e-3;   // of the coils' field: the same, and windings
  double current_error_A = 3e-3;         // of a current sensor: offset ...
  double current_error_relative = 2e-3;  // ... gain ...
  double current_change_error = 0.1;     // ... and of the change since the last scan: lag is no straight line
  double age_error_s = 5e-5;             // of a sensor's age: half its resolution
  double current_age_s = 3.75e-4;       // currents: means of 4 samples per tick, middle this long before the tick's end
  double field_max_T = 5e-3;            // a larger value is no reading
  std::int64_t age_max_ns = 5'000'000;  // an older sample is not used
};

// What is remembered of the scans before, so that each sensor's coil field is taken at that sensor's own instant.
struct CurrentHistory {
  bool valid = false;
  std::int64_t t_ns = 0;
  std::uint64_t sequence = 0;
  std::array<double, base::kCoilCount> coil_current_A{};
  double stamp_lead_s = 0;  // end of the device's tick minus t_ns. docs/theory/tracking.md (5)
};

// The history after `scan`. The stamp is that of the newest sample, the currents belong to the device's tick; the
// latest stamps of the past second show where its ticks end.
CurrentHistory Remember(const base::HallScan& scan, const CurrentHistory& previous) noexcept;

// Subtracts the coils, weighs each axis, drops what is saturated, not finite or stale. Rates are left zero.
// `now` = Remember(scan, previous).
Measurement MakeMeasurement(const Model& model, const Trust& trust, const base::HallScan& scan,
                            const CurrentHistory& previous, const CurrentHistory& now) noexcept;

}  // namespace omni::tracker
