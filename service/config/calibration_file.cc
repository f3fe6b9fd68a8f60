#include "service/config/calibration_file.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

#include "service/config/paths.h"
#include "service/config/text_file.h"
#include "service/config/toml_reader.h"

namespace omni::config {
namespace {

using base::Calibration;
using base::DeviceGeometry;
using base::SensorCalibration;
using base::Vec3;

constexpr double kPi = std::numbers::pi;
constexpr double kMovedMax_m = 0.02;   // a sensor farther from its drawing is another device
constexpr double kMomentRatioMax = 2;  // or its inverse: another magnet
constexpr std::size_t kMaxNameBytes = 64;
constexpr Range kFormat{1, 1000};
constexpr Range kPosition_m{-0.5, 0.5};
constexpr Range kGain{-2, 2};
constexpr Range kMap_T_A{-1e-2, 1e-2};
constexpr Range kBackground_T{-1e-3, 1e-3};
constexpr Range kMoment_Am2{1e-3, 1e3};
constexpr Range kKappa{0, 1.2};

std::string Hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

// FNV-1a, 64 bit, over the values written to nine digits: a file that says 0.06 and one that says 60e-3 are the same.
class GeometryDigest {
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

// Moment and shape as magnetics has them would be another module's; a cylinder's and a sphere's volume are short.
double NominalMoment(const base::MagnetGeometry& magnet) {
  const double R = magnet.radius_m;
  const double volume =
      magnet.shape == base::MagnetShape::kSphere ? 4 * kPi / 3 * R * R * R : 2 * kPi * R * R * magnet.half_height_m;
  return magnet.remanence_T * volume / (4e-7 * kPi);
}

void CheckHeader(FileProblem& problem, TableReader& root, const DeviceGeometry& device, const std::string& serial,
                 CalibrationFile& file) {
  const int format = root.Integer("format", kFormat);
  if (problem.ok() && format != kCalibrationFormat) {
    problem.Report(root.table().get("format"),
                   "format = " + std::to_string(format) + " is not known, this version reads " +
                       std::to_string(kCalibrationFormat) + "; calibrate anew: omni calibrate");
  }
  file.calibration.device = root.Text("device", kMaxNameBytes);
  file.serial = root.Text("serial", kMaxNameBytes);
  file.date = root.Text("date", kMaxNameBytes);
  const std::string hash = root.Text("device_hash", kMaxNameBytes);
  if (!problem.ok()) return;
  if (hash != Hex(GeometryHash(device))) {
    problem.Report(root.table().get("device_hash"),
                   "device_hash = " + hash + " belongs to another geometry than that of device \"" + device.name +
                       "\" (" + Hex(GeometryHash(device)) + "); calibrate this device: omni calibrate");
  } else if (!serial.empty() && file.serial != serial) {
    problem.Report(root.table().get("serial"), "serial = \"" + file.serial + "\" is another base than \"" + serial +
                                                   "\"; calibrate this one: omni calibrate");
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
  reader.Finish();
}

void ReadMagnet(FileProblem& problem, TableReader& root, const DeviceGeometry& device, Calibration& calibration) {
  const toml::table* table = root.Table("magnet");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "magnet");
  calibration.moment_Am2 = reader.Number("moment_Am2", kMoment_Am2);
  calibration.core_kappa = reader.Number("core_kappa", kKappa);
  reader.Finish();
  const double ratio = calibration.moment_Am2 / NominalMoment(device.magnet);
  if (problem.ok() && !(ratio <= kMomentRatioMax && ratio >= 1 / kMomentRatioMax)) {
    problem.Report(table->get("moment_Am2"), "magnet.moment_Am2 = " + TomlFloat(calibration.moment_Am2) +
                                                 " is not the device's magnet; calibrate anew: omni calibrate");
  }
}

void ReadSensors(FileProblem& problem, TableReader& root, const DeviceGeometry& device, Calibration& calibration) {
  const auto tables = root.Tables("sensors", device.sensors.size(), device.sensors.size());
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const std::string name = "sensors[" + std::to_string(i) + "]";
    TableReader reader(problem, *tables[i], name);
    SensorCalibration sensor;
    sensor.position_base_m = reader.Vector("position_base_m", kPosition_m);
    reader.Numbers("gain_sensor_base", kGain, sensor.gain_sensor_base);
    reader.Numbers("current_map_T_A", kMap_T_A, sensor.current_map_T_A);
    sensor.background_sensor_T = reader.Vector("background_sensor_T", kBackground_T);
    reader.Finish();
    const Vec3& drawn = device.sensors[i].position_base_m;
    const Vec3& found = sensor.position_base_m;
    const double moved_m = std::hypot(found.x - drawn.x, found.y - drawn.y, found.z - drawn.z);
    if (problem.ok() && !(moved_m <= kMovedMax_m)) {
      problem.Report(tables[i]->get("position_base_m"),
                     name + ".position_base_m is " + std::to_string(1e3 * moved_m) +
                         " mm from the drawing, allowed are 20 mm; calibrate anew: omni calibrate");
    }
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

}  // namespace

std::uint64_t GeometryHash(const DeviceGeometry& device) {
  GeometryDigest digest;
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
                                               const DeviceGeometry& device, const std::string& serial) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  CalibrationFile file;
  CheckHeader(problem, root, device, serial, file);
  if (!problem.ok()) return base::Error{problem.message()};  // of another device or version the rest says nothing
  ReadQuality(problem, root, file.quality);
  ReadMagnet(problem, root, device, file.calibration);
  ReadSensors(problem, root, device, file.calibration);
  root.Finish();
  if (!problem.ok()) return base::Error{problem.message()};
  file.calibration.expected_error_m = 1e-3 * file.quality.expected_error_mm;
  file.calibration.sensor_noise_T = device.sensor_noise_T;
  file.calibration.sensor_range_T = device.sensor_range_T;
  file.calibration.magnet = device.magnet;
  file.calibration.core_radius_m = device.core_radius_m;
  file.calibration.hull_radius_m = device.hull_radius_m;
  return file;
}

base::Result<CalibrationFile> LoadCalibrationFile(const std::string& path, const DeviceGeometry& device,
                                                  const std::string& serial) {
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseCalibration(*text, path, device, serial);
}

std::string WriteCalibration(const CalibrationFile& file, const DeviceGeometry& device) {
  const CalibrationQuality& quality = file.quality;
  std::string text = "# Self-calibration of one base, written by omni calibrate. SI units, frame B.\n";
  text += "format = " + std::to_string(kCalibrationFormat) + "\n";
  text += "device = \"" + device.name + "\"\n";
  text += "device_hash = \"" + Hex(GeometryHash(device)) + "\"\n";
  text += "serial = \"" + file.serial + "\"\n";
  text += "date = \"" + file.date + "\"\n\n[quality]\n";
  text += "expected_error_mm = " + TomlFloat(quality.expected_error_mm) + "\n";
  text += "frame_rotation_deg = " + TomlFloat(quality.frame_rotation_deg) + "\n";
  text += "chi2_per_dof = " + TomlFloat(quality.chi2_per_dof) + "\n";
  text += "coverage = " + TomlFloat(quality.coverage) + "\n";
  text += "samples = " + std::to_string(quality.samples) + "\n";
  text += "touches = " + std::to_string(quality.touches) + "\n";
  text += "unfixed = " + std::to_string(quality.unfixed) + "\n\n[magnet]\n";
  text += "moment_Am2 = " + TomlFloat(file.calibration.moment_Am2) + "\n";
  text += "core_kappa = " + TomlFloat(file.calibration.core_kappa) + "\n";
  for (const SensorCalibration& sensor : file.calibration.sensors) {
    text += "\n[[sensors]]\nposition_base_m = " + List(sensor.position_base_m) + "\n";
    text += "gain_sensor_base = " + List(sensor.gain_sensor_base) + "\n";
    text += "current_map_T_A = " + List(sensor.current_map_T_A) + "\n";
    text += "background_sensor_T = " + List(sensor.background_sensor_T) + "\n";
  }
  return text;
}

base::Status SaveCalibrationFile(const std::string& path, const CalibrationFile& file, const DeviceGeometry& device) {
  const base::Status saved = WriteTextFile(path, WriteCalibration(file, device));
  if (!saved.ok()) return base::Error{saved.error() + ", or name another file"};
  return saved;
}

CalibrationChoice ChooseCalibration(const std::string& path, const DeviceGeometry& device, const std::string& serial) {
  CalibrationChoice choice;
  choice.path = path.empty() ? UserCalibrationFile() : path;
  std::error_code error;
  if (path.empty() && (choice.path.empty() || !std::filesystem::exists(choice.path, error))) {
    choice.path.clear();
    return choice;
  }
  base::Result<CalibrationFile> loaded = LoadCalibrationFile(choice.path, device, serial);
  if (loaded.ok()) {
    choice.file = std::move(*loaded);
  } else {
    choice.problem = loaded.error() + " (not used: the base works as drawn, less precisely)";
  }
  return choice;
}

}  // namespace omni::config
