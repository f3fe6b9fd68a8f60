#include "service/config/files/calibration_file.h"

#include <fcntl.h>
#include <stdio.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "service/base/files/whole_file.h"
#include "service/config/files/calibration_check.h"
#include "service/config/files/device_file.h"
#include "service/config/paths.h"
#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

using base::Calibration;
using base::DeviceGeometry;
using base::SensorCalibration;
using base::Vec3;

constexpr const char* kMeasureAgain = "; measure this base: omni calibrate --replace";
constexpr std::size_t kMaxNameBytes = 64;
constexpr Range kFormat{1, 1000};
constexpr Range kPosition_m{-0.5, 0.5};
constexpr Range kGain{-2, 2};
constexpr Range kMap_T_A{-1e-2, 1e-2};
constexpr Range kBackground_T{-1e-3, 1e-3};
constexpr Range kMoment_Am2{1e-3, 1e3};
constexpr Range kKappa{0, 1.2};
constexpr Range kCoreKept_A{0, base::kCoreKeptMax_A};
constexpr Range kTipOffset_m{0, kTipOffsetMax_m};
constexpr Range kHullRadius_m{0, 0.5};
constexpr Range kSteelStrength{-2, 2};
constexpr Range kSteelHeight_m{-2, -0.03};

std::string Hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

// FNV-1a, 64 bit; numbers as written to nine digits: a file that says 0.06 and one that says 60e-3 are the same.
class TextDigest {
 public:
  void Add(const std::string& text) {
    for (const char c : text + "\n") hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  }
  void Add(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value == 0 ? 0.0 : value);  // -0 is 0
    Add(std::string(text));
  }
  void Add(const Vec3& v) {
    Add(v.x);
    Add(v.y);
    Add(v.z);
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037ULL;
};

void CheckHeader(FileProblem& problem, TableReader& root, const ExpectedBase& expected, CalibrationFile& file) {
  const int format = root.Integer("format", kFormat);
  if (problem.ok() && format != kCalibrationFormat) {
    problem.Report(root.table().get("format"), "format = " + std::to_string(format) +
                                                   " is not known, this version reads " +
                                                   std::to_string(kCalibrationFormat) + kMeasureAgain);
  }
  file.calibration.device = root.Text("device", kMaxNameBytes);
  file.serial = root.Text("serial", kMaxNameBytes);
  file.date = root.Text("date", kMaxNameBytes);
  const std::string hash = root.Text("device_hash", kMaxNameBytes);
  if (!problem.ok()) return;
  const std::string expected_hash = Hex(GeometryHash(expected.device));
  if (hash != expected_hash || file.calibration.device != expected.device.name) {
    problem.Report(root.table().get("device_hash"),
                   "device = \"" + file.calibration.device + "\" with device_hash = " + hash +
                       " was made for another geometry than that of device \"" + expected.device.name + "\" (" +
                       expected_hash + ")" + kMeasureAgain);
  } else if (!expected.serial.empty() && file.serial != expected.serial) {
    problem.Report(root.table().get("serial"), "serial = \"" + file.serial + "\" belongs to another base than \"" +
                                                   expected.serial + "\"" + kMeasureAgain);
  }
}

void ReadQuality(FileProblem& problem, TableReader& root, CalibrationQuality& quality) {
  const toml::table* table = root.Table("quality");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "quality");
  quality.expected_error_mm = reader.Number("expected_error_mm", {0, 100});
  quality.frame_rotation_deg = reader.Number("frame_rotation_deg", {0, 180});
  quality.chi2_per_dof = reader.Number("chi2_per_dof", {0, 1e6});
  quality.coverage = reader.Number("coverage", {0, 1});
  quality.samples = reader.Integer("samples", {0, 1e6});
  quality.touches = reader.Integer("touches", {0, 1e6});
  quality.unfixed = reader.Integer("unfixed", {0, 1e6});
  reader.ReportUnknownKeys();
}

// A pen whose tip was not measured has the drawing's, and its file does not contain one.
void ReadMagnet(FileProblem& problem, TableReader& root, CalibrationFile& file) {
  const toml::table* table = root.Table("magnet");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "magnet");
  Calibration& calibration = file.calibration;
  calibration.moment_Am2 = reader.Number("moment_Am2", kMoment_Am2);
  calibration.core_kappa = reader.Number("core_kappa", kKappa);
  calibration.core_kept_A = reader.Number("core_kept_A", kCoreKept_A, 0.0);
  file.tip_measured = table->contains("tip_offset_m");
  double& tip_offset_m = calibration.magnet.tip_offset_m;
  tip_offset_m = reader.Number("tip_offset_m", kTipOffset_m, tip_offset_m);
  reader.ReportUnknownKeys();
}

void ReadBase(FileProblem& problem, TableReader& root, Calibration& calibration) {
  const toml::table* table = root.Table("base");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "base");
  calibration.hull_radius_m = reader.Number("hull_radius_m", kHullRadius_m);
  calibration.core_centre_base_m = reader.Vector("core_centre_base_m", kPosition_m);
  reader.ReportUnknownKeys();
}

// Only in files of bases with steel under them.
void ReadSteel(FileProblem& problem, TableReader& root, Calibration& calibration) {
  if (!root.table().contains("steel")) return;
  const toml::table* table = root.Table("steel");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "steel");
  calibration.steel.strength = reader.Number("strength", kSteelStrength);
  calibration.steel.height_base_m = reader.Number("height_base_m", kSteelHeight_m);
  reader.ReportUnknownKeys();
}

std::string SensorName(std::size_t i) { return "sensors[" + std::to_string(i) + "]"; }

void ReadSensors(FileProblem& problem, TableReader& root, std::size_t count, Calibration& calibration) {
  for (const toml::table* table : root.Tables("sensors", count, count)) {
    TableReader reader(problem, *table, SensorName(calibration.sensors.size()));
    SensorCalibration sensor;
    sensor.position_base_m = reader.Vector("position_base_m", kPosition_m);
    reader.Numbers("gain_sensor_base", kGain, sensor.gain_sensor_base);
    reader.Numbers("current_map_T_A", kMap_T_A, sensor.current_map_T_A);
    sensor.background_sensor_T = reader.Vector("background_sensor_T", kBackground_T);
    reader.ReportUnknownKeys();
    calibration.sensors.push_back(sensor);
  }
}

template <std::size_t N>
std::string List(const std::array<double, N>& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < N; ++i) text += (i == 0 ? "" : ", ") + TomlFloat(values[i]);
  return text + "]";
}

std::string List(const Vec3& v) { return List(std::array<double, 3>{v.x, v.y, v.z}); }

// The content of a file, apart from its layout and its checksum.
std::string Content(const CalibrationFile& file, const DeviceGeometry& device) {
  const CalibrationQuality& quality = file.quality;
  std::string text = "format = " + std::to_string(kCalibrationFormat) + "\n";
  text += "device = " + TomlText(device.name) + "\n";
  text += "device_hash = \"" + Hex(GeometryHash(device)) + "\"\n";
  text += "serial = " + TomlText(file.serial) + "\n";
  text += "date = " + TomlText(file.date) + "\n\n[quality]\n";
  text += "expected_error_mm = " + TomlFloat(quality.expected_error_mm) + "\n";
  text += "frame_rotation_deg = " + TomlFloat(quality.frame_rotation_deg) + "\n";
  text += "chi2_per_dof = " + TomlFloat(quality.chi2_per_dof) + "\n";
  text += "coverage = " + TomlFloat(quality.coverage) + "\n";
  text += "samples = " + std::to_string(quality.samples) + "\n";
  text += "touches = " + std::to_string(quality.touches) + "\n";
  text += "unfixed = " + std::to_string(quality.unfixed) + "\n\n[magnet]\n";
  text += "moment_Am2 = " + TomlFloat(file.calibration.moment_Am2) + "\n";
  text += "core_kappa = " + TomlFloat(file.calibration.core_kappa) + "\n";
  if (file.calibration.core_kept_A != 0) text += "core_kept_A = " + TomlFloat(file.calibration.core_kept_A) + "\n";
  if (file.tip_measured) text += "tip_offset_m = " + TomlFloat(file.calibration.magnet.tip_offset_m) + "\n";
  text += "\n[base]\n";
  text += "hull_radius_m = " + TomlFloat(file.calibration.hull_radius_m) + "\n";
  text += "core_centre_base_m = " + List(file.calibration.core_centre_base_m) + "\n";
  if (const base::SteelPlane& steel = file.calibration.steel; steel.strength != 0) {
    text += "\n[steel]\nstrength = " + TomlFloat(steel.strength) + "\n";
    text += "height_base_m = " + TomlFloat(steel.height_base_m) + "\n";
  }
  for (const SensorCalibration& sensor : file.calibration.sensors) {
    text += "\n[[sensors]]\nposition_base_m = " + List(sensor.position_base_m) + "\n";
    text += "gain_sensor_base = " + List(sensor.gain_sensor_base) + "\n";
    text += "current_map_T_A = " + List(sensor.current_map_T_A) + "\n";
    text += "background_sensor_T = " + List(sensor.background_sensor_T) + "\n";
  }
  return text;
}

std::string ChecksumOf(const std::string& content) {
  TextDigest digest;
  digest.Add(content);
  return Hex(digest.value());
}

void CheckChecksum(FileProblem& problem, TableReader& root, const DeviceGeometry& device, CalibrationFile& file) {
  file.has_checksum = root.table().contains("checksum");
  if (!file.has_checksum) return;
  const std::string said = root.Text("checksum", kMaxNameBytes);
  if (!problem.ok() || said == ChecksumOf(Content(file, device))) return;
  problem.Report(
      root.table().get("checksum"),
      "checksum = " + said +
          " does not match the file's content: the file was damaged or edited; if it was edited on purpose, "
          "delete this line; else restore the previous file (omni calibrate --restore), or measure this base again "
          "(omni calibrate --replace)");
}

void CheckSense(FileProblem& problem, const toml::table& root, const Calibration& drawing, const Calibration& found) {
  if (!problem.ok()) return;
  const std::optional<ImplausibleValue> implausible = FindImplausible(drawing, found);
  if (!implausible) return;
  const bool of_sensor = implausible->sensor >= 0;
  const auto index = static_cast<std::size_t>(of_sensor ? implausible->sensor : 0);
  const auto table = of_sensor ? root["sensors"][index] : root[implausible->table];
  problem.Report(table[implausible->key].node(), (of_sensor ? SensorName(index) : implausible->table) + "." +
                                                     implausible->key + " " + implausible->what + ": " +
                                                     implausible->remedy);
}

}  // namespace

std::uint64_t GeometryHash(const DeviceGeometry& device) {
  TextDigest digest;
  digest.Add(device.name);
  for (const base::SensorGeometry& sensor : device.sensors) {
    const base::Quat& q = sensor.orientation_base_sensor;
    digest.Add(sensor.position_base_m);
    for (const double value : {q.w, q.x, q.y, q.z}) digest.Add(value);
  }
  for (const base::CoilGeometry& coil : device.coils) {
    digest.Add(coil.axis_base);
    for (const double value : {static_cast<double>(coil.turns), static_cast<double>(coil.layers),
                               coil.shell_radius_min_m, coil.shell_radius_max_m, coil.band_half_width_m}) {
      digest.Add(value);
    }
  }
  const base::MagnetGeometry& magnet = device.magnet;
  for (const double value :
       {magnet.shape == base::MagnetShape::kSphere ? 1.0 : 0.0, magnet.radius_m, magnet.half_height_m,
        magnet.remanence_T, device.core_radius_m, device.core_kappa, device.hull_radius_m, device.sensor_range_T}) {
    digest.Add(value);
  }
  return digest.value();
}

base::Result<CalibrationFile> ParseCalibration(const std::string& text, const std::string& name,
                                               const ExpectedBase& expected) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  CalibrationFile file;
  file.calibration.magnet = expected.device.magnet;
  CheckHeader(problem, root, expected, file);
  if (!problem.ok()) return base::Error{problem.message()};  // for another device or version the rest is meaningless
  ReadQuality(problem, root, file.quality);
  ReadMagnet(problem, root, file);
  ReadBase(problem, root, file.calibration);
  ReadSteel(problem, root, file.calibration);
  ReadSensors(problem, root, expected.device.sensors.size(), file.calibration);
  CheckChecksum(problem, root, expected.device, file);
  root.ReportUnknownKeys();
  CheckSense(problem, *parsed, expected.drawing, file.calibration);
  if (!problem.ok()) return base::Error{problem.message()};
  file.calibration.expected_error_m = 1e-3 * file.quality.expected_error_mm;
  file.calibration.sensor_noise_T = expected.device.sensor_noise_T;
  file.calibration.sensor_range_T = expected.device.sensor_range_T;
  file.calibration.core_radius_m = expected.device.core_radius_m;
  return file;
}

base::Result<CalibrationFile> LoadCalibrationFile(const std::string& path, const ExpectedBase& expected) {
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseCalibration(*text, path, expected);
}

std::string WriteCalibration(const CalibrationFile& file, const DeviceGeometry& device) {
  const std::string content = Content(file, device);
  return "# Self-calibration of one base, written by omni calibrate. SI units, frame B.\nchecksum = \"" +
         ChecksumOf(content) + "\"  # of the lines below; after editing them, delete this line\n" + content;
}

std::string PreviousCalibration(const std::string& path, int number) {
  const std::filesystem::path file(path);
  const std::string name = file.stem().string() + ".previous" + (number == 1 ? "" : "." + std::to_string(number));
  return (file.parent_path() / (name + file.extension().string())).string();
}

namespace {

// Leaves number 1 free; the oldest goes where all numbers are taken. One rename after another: a crash loses none.
base::Status MoveOn(const std::string& path) {
  std::error_code error;
  int free = 1;
  while (free < kPreviousCalibrations && std::filesystem::exists(PreviousCalibration(path, free), error)) ++free;
  for (int number = free; number > 1; --number) {
    const std::string to = PreviousCalibration(path, number);
    if (std::rename(PreviousCalibration(path, number - 1).c_str(), to.c_str()) != 0) {
      return base::Error{base::WriteProblem(to, errno)};
    }
  }
  return base::Ok{};
}

}  // namespace

base::Status SaveCalibrationFile(const std::string& path, const CalibrationFile& file, const ExpectedBase& expected,
                                 bool replace) {
  const std::string text = WriteCalibration(file, expected.device);
  if (auto checked = ParseCalibration(text, path, expected); !checked.ok()) return base::Error{checked.error()};
  std::error_code error;
  if (replace && std::filesystem::exists(path, error)) {
    const base::Result<std::string> old = ReadTextFile(path);
    if (!old.ok()) return base::Error{old.error()};
    if (auto moved = MoveOn(path); !moved.ok()) return moved;
    if (auto kept = base::WriteWholeFile(PreviousCalibration(path), *old); !kept.ok()) return kept;
  }
  return base::WriteWholeFile(path, text, {.replace = replace, .make_folder = true});
}

base::Status RestoreCalibrationFile(const std::string& path, const ExpectedBase& expected, int number) {
  const std::string previous = PreviousCalibration(path, number);
  const base::Result<std::string> back = ReadTextFile(previous);
  if (!back.ok()) return base::Error{back.error()};
  if (auto checked = ParseCalibration(*back, previous, expected); !checked.ok()) return base::Error{checked.error()};
  std::error_code error;
  const bool there = std::filesystem::exists(path, error);
  const unsigned how = there ? RENAME_EXCHANGE : RENAME_NOREPLACE;
  if (::renameat2(AT_FDCWD, previous.c_str(), AT_FDCWD, path.c_str(), how) == 0) return base::Ok{};
  if (errno != EINVAL && errno != ENOSYS) return base::Error{base::WriteProblem(path, errno)};
  // A file system that cannot exchange two files: one after the other, each whole at any time.
  const base::Result<std::string> current = there ? ReadTextFile(path) : std::string();
  if (!current.ok()) return base::Error{current.error()};
  if (auto put = base::WriteWholeFile(path, *back); !put.ok()) return put;
  return there ? base::WriteWholeFile(previous, *current) : base::RemoveWholeFile(previous);
}

namespace {

// A file of the user's for another base does not keep this one from having its own.
bool IsOfAnotherBase(const std::string& path, ExpectedBase expected) {
  const std::string serial = std::exchange(expected.serial, {});
  const base::Result<CalibrationFile> file = LoadCalibrationFile(path, expected);
  return file.ok() && file->serial != serial;
}

}  // namespace

CalibrationChoice ChooseCalibration(const std::string& path, const ExpectedBase& expected, const std::string& shipped) {
  CalibrationChoice choice;
  choice.path = path.empty() ? UserCalibrationFile() : path;
  std::error_code error;
  const bool none = path.empty() && (choice.path.empty() || !std::filesystem::exists(choice.path, error));
  if (path.empty() && !shipped.empty() && (none || IsOfAnotherBase(choice.path, expected))) {
    choice.path = shipped;
    choice.shipped = true;
  } else if (none) {
    choice.path.clear();
    return choice;
  }
  base::Result<CalibrationFile> loaded = LoadCalibrationFile(choice.path, expected);
  if (loaded.ok()) {
    if (!loaded->has_checksum) choice.note = "without a checksum: written by an older version, or edited by hand";
    choice.file = std::move(*loaded);
  } else {
    choice.problem = loaded.error() + " (not used: the base uses its nominal geometry, less precisely)";
  }
  return choice;
}

}  // namespace omni::config
