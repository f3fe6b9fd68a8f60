// alignments.toml: where the base stands in the reference spaces of headsets, one entry per runtime, system and space.
// Written by omnid only, on request of `omni align`. Errors name file, line, key, value and remedy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/config/files/alignment_drift.h"

namespace omni::config {

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
