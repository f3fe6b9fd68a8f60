// How far off a stored placement may be by now. A headset finds its room again at each start, and its spaces come back
// some millimetres elsewhere (7 to 20 mm were seen; with base stations less than one): the error of a placement grows
// with the starts since it was measured. `omni align --check` measures it, and how fast it grows with this headset.
#pragma once

#include <cstdint>

namespace omni::config {

// The headset counts as started when an application uses a placement that none has used for so long.
inline constexpr std::int64_t kHeadsetPause_s = 1800;

struct AlignmentDrift {
  int starts = 0;             // of the headset since the placement was measured or checked; see kHeadsetPause_s
  double checked_m = 0;       // how far off it was found then, or kCheckError_m once corrected; 0: not checked
  double per_start_m = 7e-3;  // rms, norm over axes
  int checks = 0;             // that per_start_m has learned from
};

// Beyond this a pose is no longer called tracked; or beyond half more than was accepted when it was measured.
inline constexpr double kMostAlignmentError_m = 10e-3;
inline constexpr double kMostAlignmentGrowth = 1.5;

// Of a check itself, rms over simulated people (ToolsAlignSession.CheckFindsTheFirstMark).
inline constexpr double kCheckError_m = 2e-3;

// sqrt(max(e, c)^2 + n d^2): 1 sigma, norm over axes; e as measured, c as checked, n starts of d each.
double ErrorNow_m(double expected_error_m, const AlignmentDrift& drift) noexcept;

bool HasDrifted(double expected_error_m, const AlignmentDrift& drift) noexcept;

// A check found the placement `offset_m` off. With `corrected` it was moved to where it belongs.
// [docs/theory/alignment.md (9), (10)]
//   d^2 <- ((w + k) d^2 + max(0, o^2 - e^2 - s^2) / n) / (w + k + 1), with k checks before and the weight w = 1/4 of
//   the first guess; a check without a start in between learns nothing.
AlignmentDrift Checked(AlignmentDrift drift, double offset_m, double expected_error_m, bool corrected) noexcept;

}  // namespace omni::config
