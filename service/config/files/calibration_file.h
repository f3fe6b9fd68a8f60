// calibration.toml: the result of self-calibration of one particular base. Errors name file, key, value and remedy.
// Sizes that calibration does not measure (magnet, core, noise) come from the device's geometry, as does the pen's tip
// until `omni calibrate --tip` has measured it.
//
// A file carries a checksum of its content (not of its layout and comments). A file with a wrong one is rejected; one
// without a checksum (an older version, a deliberate edit) is used, with a note.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "service/base/device_geometry.h"
#include "service/base/result.h"

namespace omni::config {

inline constexpr int kCalibrationFormat = 2;

// What the adjustment reports about its result.
struct CalibrationQuality {
  double expected_error_mm = 0;   // rms position error that it leaves, noise apart
  double frame_rotation_deg = 0;  // how well the frame's rotation about the core is known
  double chi2_per_dof = 0;
  double coverage = 0;  // of the upper hemisphere, 0 to 1
  int samples = 0;
  int touches = 0;
  int unfixed = 0;  // parameters that the recording did not fix
};

struct CalibrationFile {
  base::Calibration calibration;
  std::string serial;  // of the base
  std::string date;    // ISO 8601, UTC
  CalibrationQuality quality;
  bool tip_measured = false;  // calibration.magnet.tip_offset_m is this pen's; else it is the drawing's and not written
  bool has_checksum = false;  // as read
};

// The base that a calibration must belong to.
struct ExpectedBase {
  base::DeviceGeometry device;
  base::Calibration drawing;  // of `device` (magnetics::NominalCalibration): a file that is far from it is refused
  std::string serial;         // empty: any
};

// Over everything of the geometry that calibration starts from, to 9 digits; electrical limits are left out.
std::uint64_t GeometryHash(const base::DeviceGeometry& device);

base::Result<CalibrationFile> LoadCalibrationFile(const std::string& path, const ExpectedBase& expected);
// `name` stands for the file in messages.
base::Result<CalibrationFile> ParseCalibration(const std::string& text, const std::string& name,
                                               const ExpectedBase& expected);

std::string WriteCalibration(const CalibrationFile& file, const base::DeviceGeometry& device);

// So many files that `path` replaced are kept, the newest as number 1: "calibration.previous.toml", then
// "calibration.previous.2.toml" ...
inline constexpr int kPreviousCalibrations = 5;
std::string PreviousCalibration(const std::string& path, int number = 1);
// Writes no file that LoadCalibrationFile would reject. With `replace` an existing file becomes the newest previous
// one, and older ones move on; without it, this fails. Makes the folder.
base::Status SaveCalibrationFile(const std::string& path, const CalibrationFile& file, const ExpectedBase& expected,
                                 bool replace);
// Exchanges `path` and a previous file, at once: a second call undoes the first, and whatever happens both are whole.
base::Status RestoreCalibrationFile(const std::string& path, const ExpectedBase& expected, int number = 1);

// Which calibration a program uses: `path` if given, else the user's own file if there is one. `shipped`: of this base,
// if Omni has one; used where the user has none for it.
struct CalibrationChoice {
  std::optional<CalibrationFile> file;  // none: the drawing is used
  std::string path;                     // of the file, or of the rejected one; empty: there is none
  std::string problem;                  // why an existing file is not used
  std::string note;                     // a remark about the file in use; mostly empty
  bool shipped = false;                 // the file is Omni's
};
CalibrationChoice ChooseCalibration(const std::string& path, const ExpectedBase& expected,
                                    const std::string& shipped = {});

}  // namespace omni::config
