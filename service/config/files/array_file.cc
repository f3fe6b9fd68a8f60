#include "service/config/files/array_file.h"

#include <cmath>
#include <numbers>
#include <span>

#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

using Matrix = std::array<double, 9>;  // row-major

constexpr Range kPosition_m{-10, 10};
constexpr Range kDirection{-1.01, 1.01};
constexpr Range kAngle_rad{-2 * std::numbers::pi, 2 * std::numbers::pi};
constexpr Range kGain{-100, 100};
constexpr Range kBackground_T{-0.1, 0.1};
constexpr Range kMap_T_A{-1, 1};
constexpr double kUnitTolerance = 1e-2;
constexpr Range kRowLength{1e-3, 200};  // of an axis of the whole map: 0 would be a dead axis

// R_SB, the transpose of the rotation that a unit quaternion (w, x, y, z) makes.
Matrix TransposedRotation(const std::array<double, 4>& q) {
  const auto [w, x, y, z] = q;
  return {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),
          2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
          2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y)};
}

std::array<double, 4> Quaternion(FileProblem& problem, TableReader& reader) {
  std::array<double, 4> q{};
  reader.Numbers("orientation_base_sensor", kDirection, q);
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(length - 1) <= kUnitTolerance)) {
    problem.Report(reader.table().get("orientation_base_sensor"),
                   reader.NameOf("orientation_base_sensor") + " has length " + std::to_string(length) +
                       "; must be a unit quaternion w, x, y, z (length 1)");
    return {1, 0, 0, 0};
  }
  for (double& value : q) value /= length;
  return q;
}

std::array<double, 4> FromRotationVector(TableReader& reader) {
  const base::Vec3 v = reader.Vector("rotation_base_sensor_rad", kAngle_rad);
  const double angle = Norm(v);
  const double s = angle > 0 ? std::sin(angle / 2) / angle : 0.5;
  return {std::cos(angle / 2), s * v.x, s * v.y, s * v.z};
}

Matrix Product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t column = 0; column < 3; ++column) c[3 * row + column] += a[3 * row + k] * b[3 * k + column];
    }
  }
  return c;
}

Matrix Gain(TableReader& reader) {
  const toml::node* node = reader.table().get("gain");
  if (node == nullptr) return {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const toml::array* array = node->as_array();
  if (array == nullptr) {
    const double gain = reader.Number("gain", kGain);
    return {gain, 0, 0, 0, gain, 0, 0, 0, gain};
  }
  if (array->size() == 9) {
    Matrix gain{};
    reader.Numbers("gain", kGain, gain);
    return gain;
  }
  const base::Vec3 gain = reader.Vector("gain", kGain);
  return {gain.x, 0, 0, 0, gain.y, 0, 0, 0, gain.z};
}

Matrix Orientation(FileProblem& problem, TableReader& reader) {
  int given = 0;
  for (const char* key : {"orientation_base_sensor", "rotation_base_sensor_rad", "gain_sensor_base"}) {
    given += reader.table().contains(key) ? 1 : 0;
  }
  if (given > 1) {
    problem.Report(&reader.table(), reader.NameOf("orientation_base_sensor") +
                                        ", rotation_base_sensor_rad and gain_sensor_base exclude each other; keep one");
  }
  if (reader.table().contains("gain_sensor_base")) {
    Matrix whole{};
    reader.Numbers("gain_sensor_base", kGain, whole);
    return whole;
  }
  if (reader.table().contains("orientation_base_sensor")) return TransposedRotation(Quaternion(problem, reader));
  if (reader.table().contains("rotation_base_sensor_rad")) return TransposedRotation(FromRotationVector(reader));
  return {1, 0, 0, 0, 1, 0, 0, 0, 1};
}

// How the sensor stands: orientation_base_sensor (quaternion w, x, y, z), rotation_base_sensor_rad (rotation vector) or
// gain_sensor_base (the whole 3x3 map, gain included); none of them: aligned with B. `gain`: a number, three (one per
// axis) or nine (row-major, applied in the sensor's frame).
base::SensorCalibration ReadArraySensor(FileProblem& problem, TableReader& reader) {
  base::SensorCalibration sensor;
  sensor.position_base_m = reader.Vector("position_base_m", kPosition_m);
  const Matrix orientation = Orientation(problem, reader);
  sensor.gain_sensor_base = Product(Gain(reader), orientation);
  for (std::size_t row = 0; problem.ok() && row < 3; ++row) {
    const double* g = &sensor.gain_sensor_base[3 * row];
    const double length = std::hypot(g[0], g[1], g[2]);
    if (!(length >= kRowLength.low && length <= kRowLength.high)) {
      problem.Report(&reader.table(), reader.NameOf("gain") + ": axis " + std::to_string(row) + " has the gain " +
                                          std::to_string(length) + "; must be in [0.001, 200]");
    }
  }
  sensor.background_sensor_T = reader.Vector("background_sensor_T", kBackground_T, base::Vec3{});
  if (reader.table().contains("current_map_T_A")) reader.Numbers("current_map_T_A", kMap_T_A, sensor.current_map_T_A);
  return sensor;
}

using base::Calibration;
using base::CoilGeometry;
using base::MagnetGeometry;
using base::MagnetShape;

constexpr std::string_view kFormats[] = {"omni-array 1"};
constexpr std::string_view kShapes[] = {"cylinder", "sphere"};
constexpr std::size_t kMaxNameBytes = 64;

// Wide enough for capsules in the gut and for magnets that need two hands, too narrow for a mistake in the unit.
constexpr Range kMagnetSize_m{1e-4, 0.2};
constexpr Range kRemanence_T{0.01, 2};
constexpr Range kMoment_Am2{1e-6, 1e4};
constexpr Range kTipOffset_m{0, 0.5};
constexpr Range kNoise_T{1e-12, 1e-2};
constexpr Range kFullScale_T{1e-6, 20};
constexpr Range kRadius_m{1e-3, 1};
constexpr Range kKappa{0, 1};
constexpr Range kVolume_m{-10, 10};
constexpr Range kTurns{1, 100000};
constexpr Range kLayers{1, 1000};

void ReadMagnet(FileProblem& problem, TableReader& root, Calibration& into) {
  const toml::table* table = root.Table("magnet");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "magnet");
  MagnetGeometry& magnet = into.magnet;
  magnet.shape =
      reader.Choice("shape", kShapes, "cylinder") == "sphere" ? MagnetShape::kSphere : MagnetShape::kCylinder;
  magnet.radius_m = reader.Number("radius_m", kMagnetSize_m);
  magnet.half_height_m =
      magnet.shape == MagnetShape::kSphere ? magnet.radius_m : reader.Number("half_height_m", kMagnetSize_m);
  if (table->contains("remanence_T") == table->contains("moment_Am2")) {
    problem.Report(table, "magnet must have either moment_Am2 or remanence_T; give exactly one of them");
  }
  if (table->contains("moment_Am2")) {
    into.moment_Am2 = reader.Number("moment_Am2", kMoment_Am2);
  } else {
    magnet.remanence_T = reader.Number("remanence_T", kRemanence_T);
  }
  magnet.tip_offset_m = reader.Number("tip_offset_m", kTipOffset_m, 0.0);
  reader.ReportUnknownKeys();
}

void ReadNoise(FileProblem& problem, TableReader& root, Calibration& into) {
  const toml::table* table = root.Table("sensor");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "sensor");
  reader.Numbers("sensor_noise_T", kNoise_T, into.sensor_noise_T);
  if (table->contains("sensor_range_T")) into.sensor_range_T = reader.Number("sensor_range_T", kFullScale_T);
  reader.ReportUnknownKeys();
}

void ReadSensors(FileProblem& problem, TableReader& root, Calibration& into) {
  const auto tables = root.Tables("sensors", base::kArraySensorsMin, base::kArraySensorsMax);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    TableReader reader(problem, *tables[i], "sensors[" + std::to_string(i) + "]");
    into.sensors.push_back(ReadArraySensor(problem, reader));
    reader.ReportUnknownKeys();
  }
}

void ReadBodies(FileProblem& problem, TableReader& root, Calibration& into) {
  if (root.table().contains("core")) {
    if (const toml::table* table = root.Table("core"); table != nullptr) {
      TableReader reader(problem, *table, "core");
      into.core_radius_m = reader.Number("core_radius_m", kRadius_m);
      into.core_kappa = reader.Number("core_kappa", kKappa, 1.0);
      reader.ReportUnknownKeys();
    }
  }
  if (root.table().contains("hull")) {
    if (const toml::table* table = root.Table("hull"); table != nullptr) {
      TableReader reader(problem, *table, "hull");
      into.hull_radius_m = reader.Number("hull_radius_m", kRadius_m);
      reader.ReportUnknownKeys();
    }
  }
  if (root.table().contains("volume")) {
    if (const toml::table* table = root.Table("volume"); table != nullptr) {
      TableReader reader(problem, *table, "volume");
      into.volume_min_base_m = reader.Vector("min_base_m", kVolume_m);
      into.volume_max_base_m = reader.Vector("max_base_m", kVolume_m);
      reader.ReportUnknownKeys();
    }
  }
}

CoilGeometry ReadCoil(FileProblem& problem, TableReader& reader) {
  CoilGeometry coil;
  const base::Vec3 axis = reader.Vector("axis_base", kDirection);
  const double length = Norm(axis);
  if (problem.ok() && !(std::abs(length - 1) <= kUnitTolerance)) {
    problem.Report(reader.table().get("axis_base"), reader.NameOf("axis_base") + " has length " +
                                                        std::to_string(length) + "; must be a unit vector (length 1)");
  }
  coil.axis_base = {axis.x / length, axis.y / length, axis.z / length};
  coil.turns = reader.Integer("turns", kTurns);
  coil.layers = reader.Integer("layers", kLayers);
  coil.shell_radius_min_m = reader.Number("shell_radius_min_m", kRadius_m);
  coil.shell_radius_max_m = reader.Number("shell_radius_max_m", kRadius_m);
  coil.band_half_width_m = reader.Number("band_half_width_m", {1e-4, 1});
  if (!(coil.shell_radius_min_m < coil.shell_radius_max_m && coil.band_half_width_m < coil.shell_radius_min_m)) {
    problem.Report(&reader.table(), reader.NameOf("shell_radius_min_m") +
                                        " must be < shell_radius_max_m and > band_half_width_m; correct the winding");
  }
  return coil;
}

void ReadCoils(FileProblem& problem, TableReader& root, ArrayFile& into) {
  if (!root.table().contains("coils")) return;
  for (const base::SensorCalibration& sensor : into.calibration.sensors) {
    if (sensor.current_map_T_A != std::array<double, 9>{}) {
      problem.Report(root.table().get("coils"),
                     "coils and current_map_T_A exclude each other; keep the windings or the measured maps");
      break;
    }
  }
  const auto tables = root.Tables("coils", base::kCoilCount, base::kCoilCount);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    TableReader reader(problem, *tables[i], "coils[" + std::to_string(i) + "]");
    into.coils.push_back(ReadCoil(problem, reader));
    reader.ReportUnknownKeys();
  }
}

// What single ranges cannot show; empty: nothing.
std::string Contradiction(const ArrayFile& file) {
  const Calibration& array = file.calibration;
  if (array.core_radius_m > 0 && array.hull_radius_m > 0 && !(array.core_radius_m < array.hull_radius_m)) {
    return "core.core_radius_m must be < hull.hull_radius_m; correct one of the two";
  }
  const base::Vec3& low = array.volume_min_base_m;
  const base::Vec3& high = array.volume_max_base_m;
  if (low != high && !(low.x < high.x && low.y < high.y && low.z < high.z)) {
    return "volume.min_base_m must be below volume.max_base_m on every axis; correct the corners";
  }
  for (std::size_t i = 0; i < array.sensors.size(); ++i) {
    const base::Vec3& p = array.sensors[i].position_base_m;
    const std::string name = "sensors[" + std::to_string(i) + "]";
    if (!(Norm(p) > array.core_radius_m || array.core_radius_m == 0)) {
      return name + " lies in the core; correct position_base_m or core_radius_m";
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (array.sensors[k].position_base_m == p &&
          array.sensors[k].gain_sensor_base == array.sensors[i].gain_sensor_base) {
        return "sensors[" + std::to_string(k) + "] and " + name +
               " have the same position and orientation; correct position_base_m";
      }
    }
  }
  return {};
}

std::string List(std::span<const double> values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "[" : ", ") + TomlFloat(value);
  return text + "]";
}

std::string List(const base::Vec3& v) { return List(std::array{v.x, v.y, v.z}); }

}  // namespace

bool IsArrayText(const std::string& text) {
  const base::Result<toml::table> parsed = ParseToml(text, "");
  return parsed.ok() && parsed->contains("format");
}

base::Result<ArrayFile> ParseArray(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  if (!parsed->contains("format")) problem.Report(&*parsed, "format is missing; add format = \"omni-array 1\"");
  root.Choice("format", kFormats, kFormats[0]);
  ArrayFile file;
  Calibration& array = file.calibration;
  array.device = root.Text("name", kMaxNameBytes);
  ReadMagnet(problem, root, array);
  ReadNoise(problem, root, array);
  ReadSensors(problem, root, array);
  ReadBodies(problem, root, array);
  ReadCoils(problem, root, file);
  root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  if (const std::string contradiction = Contradiction(file); !contradiction.empty()) {
    return base::Error{name + ": " + contradiction};
  }
  return file;
}

std::string WriteArray(const Calibration& array) {
  const bool sphere = array.magnet.shape == MagnetShape::kSphere;
  std::string text = "format = \"omni-array 1\"\nname = \"" + array.device + "\"\n\n[magnet]\nshape = \"";
  text += sphere ? "sphere\"\n" : "cylinder\"\n";
  text += "radius_m = " + TomlFloat(array.magnet.radius_m) + "\n";
  if (!sphere) text += "half_height_m = " + TomlFloat(array.magnet.half_height_m) + "\n";
  text += "moment_Am2 = " + TomlFloat(array.moment_Am2) + "\n";
  text += "tip_offset_m = " + TomlFloat(array.magnet.tip_offset_m) + "\n";
  text += "\n[sensor]\nsensor_noise_T = " + List(array.sensor_noise_T) + "\n";
  if (array.sensor_range_T > 0) text += "sensor_range_T = " + TomlFloat(array.sensor_range_T) + "\n";
  if (array.core_radius_m > 0) {
    text += "\n[core]\ncore_radius_m = " + TomlFloat(array.core_radius_m) + "\n";
    text += "core_kappa = " + TomlFloat(array.core_kappa) + "\n";
  }
  if (array.hull_radius_m > 0) text += "\n[hull]\nhull_radius_m = " + TomlFloat(array.hull_radius_m) + "\n";
  if (array.volume_min_base_m != array.volume_max_base_m) {
    text += "\n[volume]\nmin_base_m = " + List(array.volume_min_base_m) + "\n";
    text += "max_base_m = " + List(array.volume_max_base_m) + "\n";
  }
  for (const base::SensorCalibration& sensor : array.sensors) {
    text += "\n[[sensors]]\nposition_base_m = " + List(sensor.position_base_m) + "\n";
    text += "gain_sensor_base = " + List(sensor.gain_sensor_base) + "\n";
    text += "background_sensor_T = " + List(sensor.background_sensor_T) + "\n";
    if (sensor.current_map_T_A != std::array<double, 9>{}) {
      text += "current_map_T_A = " + List(sensor.current_map_T_A) + "\n";
    }
  }
  return text;
}

}  // namespace omni::config
