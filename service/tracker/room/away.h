// Learns from readings while no pen is near: the uniform field as it is now, and each sensor's own zero, which drifts
// with its temperature. Never a magnet's field, whose gradient over the sensors stands out. docs/theory/tracking.md
// (14.1) - (14.3)
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/tracker/kernel/measurement.h"
#include "service/tracker/room/drift.h"

namespace omni::tracker {

struct AwayOptions {
  bool enabled = true;
  double window_s = 0.5;      // whose mean is evaluated ...
  int window_scans = 16;      // ... of at least so many scans
  double gradient_max = 3.5;  // per degree of freedom, over the rest: zeros: below 3 in 19 of 20; a magnet: above 8
  double quiet_T = 3e-7;      // rms of a mean that shows nothing, apart from twice the zeros' uncertainty
  double steady_T = 5e-7;     // the uniform field from one window to the next: nothing moves
  double ambient_T = 2e-6;    // to which it is known then: a magnet 0.8 m away makes as much
  double zero_T = 5e-6;       // by which a zero may have drifted in zero_s, and since the calibration
  double zero_s = 3600;
  double core_A = 0.011;         // what the core keeps, as currents: no zero
  double window_error_T = 1e-6;  // error of a mean as a measure of a zero: makes slow what looks sure
};

struct Away {
  int scans = 0;              // of the window; 0: none has begun
  std::int64_t begun_ns = 0;  // the window's first scan
  ReadingLanes sum_T{};       // over it, in the sensors' axes
  bool has_uniform = false;   // `uniform_base_T` is of the window before
  std::array<double, 3> uniform_base_T{};
  bool learnt = false;       // `zero_T` is subtracted from every scan
  std::int64_t zero_ns = 0;  // when zero_variance_T2 held
  double zero_variance_T2 = 0;
  ReadingLanes zero_T{};  // without what is uniform
};
static_assert(std::is_trivially_copyable_v<Away>);

// Nothing has been learnt yet.
void StartAway(const AwayOptions& options, std::int64_t t_ns, Away& away) noexcept;

// Subtracts the zeros from a scan.
void SubtractZeros(const Away& away, base::HallScan& scan) noexcept;

// A pen is there: the window is over.
inline void EndAwayWindow(Away& away) noexcept {
  away.scans = 0;
  away.has_uniform = false;
}

// A scan, zeros subtracted, that no pose explains. True: the zeros were learnt, only a uniform field is left.
bool WatchAway(const AwayOptions& options, const Model& model, const base::HallScan& scan, DriftState& drift,
               Away& away) noexcept;

}  // namespace omni::tracker
