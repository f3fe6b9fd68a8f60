// alignments.toml: where the base stands in the reference spaces of headsets, one entry per runtime, system and space.
// Written by omnid only, on request of `omni align`. Errors name file, line, key, value and remedy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::config {

// How far off a stored base pose may be by now. A headset finds its room again at each start, and its spaces come back
// some millimetres elsewhere (7 to 20 mm were seen; with base stations less than one): the error of a base pose grows
// with the starts since it was measured. `omni align --check` measures it, and how fast it grows with this headset.

// The headset counts as started when an application uses a base pose that none has used for so long.
inline constexpr std::int64_t kHeadsetPause_s = 1800;

struct AlignmentDrift {
  int starts = 0;             // of the headset since the base pose was measured or checked; see kHeadsetPause_s
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

// A check found the base pose `offset_m` off. With `corrected` it was moved to where it belongs.
// [docs/theory/alignment.md (9), (10)]
//   d^2 <- ((w + k) d^2 + max(0, o^2 - e^2 - s^2) / n) / (w + k + 1), with k checks before and the weight w = 1/4 of
//   the first guess; a check without a start in between learns nothing.
AlignmentDrift DriftAfterCheck(AlignmentDrift drift, double offset_m, double expected_error_m, bool corrected) noexcept;

inline constexpr int kAlignmentFormat = 1;
inline constexpr std::size_t kMaxAlignments = 64;  // storing one more is refused

enum class UncalibratedPolicy : std::uint8_t { kFrontOfUser, kCalibrated, kOff };

struct AlignmentEntry {
  std::string runtime;           // XrInstanceProperties::runtimeName
  std::string system;            // XrSystemProperties::systemName
  int space = 0;                 // XrReferenceSpaceType: 2 LOCAL, 3 STAGE, 1000426000 LOCAL_FLOOR, ...
  base::Quat orientation_space;  // of the base (z up) in the space (y up), moved along with every recentring
  base::Vec3 position_space_m;
  base::Quat measured_orientation_space;  // the same when it was measured
  base::Vec3 measured_position_space_m;
  std::string method;  // "touch", "sweep", "fingertip", "nudge"
  std::string date;    // ISO 8601, UTC
  int samples = 0;
  double rms_mm = 0;
  double expected_error_mm = 0;  // 1 sigma where the pen is used; 0: not stated
  double rotation_deg = 0;       // 1 sigma
  int recentred = 0;             // changes of the space that were applied since it was measured
  bool doubtful = false;         // the space was moved, and it is not known where to
  // Of the earth and the room, where the base stood then. Empty: not known yet.
  std::optional<base::Vec3> field_base_T;
  bool base_moved = false;  // it is another one now: the base was turned or carried
  AlignmentDrift drift;
  std::string used;  // when an application last used it, as `date`; empty: not known
  double ErrorNow_mm() const { return 1e3 * ErrorNow_m(1e-3 * expected_error_mm, drift); }
  bool IsDrifted() const { return HasDrifted(1e-3 * expected_error_mm, drift); }
  bool IsTrusted() const { return !doubtful && !base_moved && !IsDrifted(); }
};

struct AlignmentFile {
  UncalibratedPolicy uncalibrated = UncalibratedPolicy::kFrontOfUser;
  std::vector<AlignmentEntry> entries;
};

// "front-of-user", "calibrated", "off"
const char* PolicyName(UncalibratedPolicy policy);

// A missing file reads as an empty one.
base::Result<AlignmentFile> LoadAlignmentFile(const std::string& path);
// `name` stands for the file in messages.
base::Result<AlignmentFile> ParseAlignments(const std::string& text, const std::string& name);

std::string WriteAlignments(const AlignmentFile& file);

}  // namespace omni::config
