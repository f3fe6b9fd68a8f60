#include "service/config/files/device_file.h"

#include <cmath>
#include <cstdio>

#include "service/config/files/built_in_device.h"
#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

using base::Vec3;

constexpr double kAxesVolumeMin = 0.5;  // |det| of the three coil axes; 1: perpendicular, 0: in one plane

double Volume(const Vec3& a, const Vec3& b, const Vec3& c) {
  return a.x * (b.y * c.z - b.z * c.y) - a.y * (b.x * c.z - b.z * c.x) + a.z * (b.x * c.y - b.y * c.x);
}

constexpr double kCounts = 32768;  // of 16 bits, on one side of zero

// "<left> = 0.01 must be < <right> = 0.015", if it is not so.
std::string NotLess(const std::string& left, double left_value, const std::string& right, double right_value,
                    bool or_equal) {
  if (or_equal ? left_value <= right_value : left_value < right_value) return {};
  char values[2][32];
  std::snprintf(values[0], sizeof(values[0]), "%.9g", left_value);
  std::snprintf(values[1], sizeof(values[1]), "%.9g", right_value);
  return left + " = " + values[0] + " must be " + (or_equal ? "<= " : "< ") + right + " = " + values[1] +
         "; correct one of the two";
}

std::string CoilProblem(const base::DeviceGeometry& device, std::size_t i) {
  const base::CoilGeometry& coil = device.coils[i];
  const std::string name = "coils[" + std::to_string(i) + "].";
  std::string problem =
      NotLess("core.core_radius_m", device.core_radius_m, name + "shell_radius_min_m", coil.shell_radius_min_m, true);
  if (problem.empty()) {
    problem = NotLess(name + "shell_radius_min_m", coil.shell_radius_min_m, name + "shell_radius_max_m",
                      coil.shell_radius_max_m, false);
  }
  if (problem.empty()) {
    problem =
        NotLess(name + "shell_radius_max_m", coil.shell_radius_max_m, "hull.hull_radius_m", device.hull_radius_m, true);
  }
  // Turns lie at distances up to the half width from the middle plane: on every shell they need room.
  if (problem.empty()) {
    problem = NotLess(name + "band_half_width_m", coil.band_half_width_m, name + "shell_radius_min_m",
                      coil.shell_radius_min_m, false);
  }
  return problem;
}

std::string SensorProblem(const base::DeviceGeometry& device, std::size_t i) {
  const Vec3& p = device.sensors[i].position_base_m;
  const std::string name = "|sensors[" + std::to_string(i) + "].position_base_m|";
  std::string problem = NotLess("core.core_radius_m", device.core_radius_m, name, Norm(p), false);
  for (std::size_t k = 0; problem.empty() && k < i; ++k) {
    if (device.sensors[k].position_base_m == p) {
      problem = "sensors[" + std::to_string(k) + "] and sensors[" + std::to_string(i) +
                "] are at the same place; correct position_base_m";
    }
  }
  return problem;
}

// Whether the numbers of a device fit together: what single ranges cannot show. The first contradiction, with the keys
// and values involved and what must hold; empty: none.
std::string GeometryProblem(const base::DeviceGeometry& device) {
  std::string problem =
      NotLess("core.core_radius_m", device.core_radius_m, "hull.hull_radius_m", device.hull_radius_m, false);
  if (problem.empty()) {
    problem =
        NotLess("sensor.sensor_lsb_T", device.sensor_lsb_T, "sensor.sensor_range_T", device.sensor_range_T, false);
  }
  if (problem.empty()) {
    problem = NotLess("sensor.sensor_range_T", device.sensor_range_T, "32768 times sensor.sensor_lsb_T",
                      kCounts * device.sensor_lsb_T, false);
  }
  if (problem.empty()) {
    problem = NotLess("limits.temperature_derate_C", device.temperature_derate_C, "limits.temperature_max_C",
                      device.temperature_max_C, false);
  }
  for (std::size_t i = 0; problem.empty() && i < device.coils.size(); ++i) problem = CoilProblem(device, i);
  for (std::size_t i = 0; problem.empty() && i < device.sensors.size(); ++i) problem = SensorProblem(device, i);
  const double volume =
      std::abs(Volume(device.coils[0].axis_base, device.coils[1].axis_base, device.coils[2].axis_base));
  if (problem.empty() && !(volume >= kAxesVolumeMin)) {
    problem = "the three coils' axis_base span a volume of " + std::to_string(volume) +
              " (perpendicular: 1), must be at least 0.5; correct the axes";
  }
  return problem;
}

using base::CoilGeometry;
using base::DeviceGeometry;
using base::MagnetGeometry;

// One number of a table: its key is the field's name. Ranges are those of desktop devices of this kind: a value outside
// is a mistake (mm for m, gauss for tesla), not an unusual design.
template <class T>
struct NumberKey {
  const char* key;
  double T::*field;
  Range range;
};

constexpr NumberKey<MagnetGeometry> kMagnetKeys[] = {
    {"radius_m", &MagnetGeometry::radius_m, {1e-3, 0.05}},
    {"half_height_m", &MagnetGeometry::half_height_m, {2e-4, 0.05}},
    {"remanence_T", &MagnetGeometry::remanence_T, {0.1, 1.6}},
    {"mass_kg", &MagnetGeometry::mass_kg, {1e-3, 1}},
    {"tip_offset_m", &MagnetGeometry::tip_offset_m, {0, kTipOffsetMax_m}},
};
constexpr NumberKey<DeviceGeometry> kCoreKeys[] = {
    {"core_radius_m", &DeviceGeometry::core_radius_m, {1e-3, 0.1}},
    {"core_kappa", &DeviceGeometry::core_kappa, {0, 1}},
};
constexpr NumberKey<DeviceGeometry> kHullKeys[] = {
    {"hull_radius_m", &DeviceGeometry::hull_radius_m, {2e-3, 0.2}},
};
constexpr NumberKey<DeviceGeometry> kSensorKeys[] = {
    {"sensor_range_T", &DeviceGeometry::sensor_range_T, {1e-5, 1}},
    {"sensor_lsb_T", &DeviceGeometry::sensor_lsb_T, {1e-12, 1e-3}},
};
constexpr NumberKey<DeviceGeometry> kLimitKeys[] = {
    {"current_max_A", &DeviceGeometry::current_max_A, {0.01, 100}},
    {"current_slew_A_s", &DeviceGeometry::current_slew_A_s, {1, 1e7}},
    {"force_max_N", &DeviceGeometry::force_max_N, {0.01, 20}},
    {"temperature_derate_C", &DeviceGeometry::temperature_derate_C, {0, 150}},
    {"temperature_max_C", &DeviceGeometry::temperature_max_C, {0, 200}},
    {"supply_V", &DeviceGeometry::supply_V, {1, 100}},
};
constexpr NumberKey<base::HeatGeometry> kHeatKeys[] = {
    {"copper_J_K", &base::HeatGeometry::copper_J_K, {0.1, 1e5}},
    {"body_J_K", &base::HeatGeometry::body_J_K, {0.1, 1e6}},
    {"copper_to_body_W_K", &base::HeatGeometry::copper_to_body_W_K, {1e-3, 1e3}},
    {"body_to_air_W_K", &base::HeatGeometry::body_to_air_W_K, {1e-3, 1e3}},
    {"air_C", &base::HeatGeometry::air_C, {-20, 60}},
};
constexpr NumberKey<CoilGeometry> kCoilKeys[] = {
    {"shell_radius_min_m", &CoilGeometry::shell_radius_min_m, {1e-3, 0.2}},
    {"shell_radius_max_m", &CoilGeometry::shell_radius_max_m, {1e-3, 0.2}},
    {"band_half_width_m", &CoilGeometry::band_half_width_m, {1e-4, 0.2}},
    {"resistance_20C_ohm", &CoilGeometry::resistance_20C_ohm, {1e-3, 1e3}},
    {"inductance_H", &CoilGeometry::inductance_H, {1e-7, 1}},
};
constexpr Range kSensorNoise_T{0, 1e-3};
constexpr Range kPosition_m{-0.5, 0.5};
constexpr Range kDirection{-1.01, 1.01};
constexpr Range kTurns{1, 100000};
constexpr Range kLayers{1, 1000};
constexpr double kUnitTolerance = 1e-2;  // a direction typed by hand is normalised, a wrong one refused
constexpr std::size_t kMaxNameBytes = 64;

template <class T, std::size_t N>
void ReadNumbers(TableReader& reader, const NumberKey<T> (&keys)[N], T& into) {
  for (const NumberKey<T>& entry : keys) into.*entry.field = reader.Number(entry.key, entry.range);
}

// [name]: a table of numbers of DeviceGeometry, nothing else.
template <std::size_t N>
void ReadSection(FileProblem& problem, TableReader& root, const char* name, const NumberKey<DeviceGeometry> (&keys)[N],
                 DeviceGeometry& device) {
  const toml::table* table = root.Table(name);
  if (table == nullptr) return;
  TableReader reader(problem, *table, name);
  ReadNumbers(reader, keys, device);
  reader.ReportUnknownKeys();
}

void ReadMagnet(FileProblem& problem, TableReader& root, MagnetGeometry& magnet) {
  const toml::table* table = root.Table("magnet");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "magnet");
  ReadNumbers(reader, kMagnetKeys, magnet);
  reader.ReportUnknownKeys();
}

// Optional: without the table the defaults hold, with it every key is required.
void ReadHeat(FileProblem& problem, const toml::table& file, TableReader& root, base::HeatGeometry& heat) {
  if (!file.contains("heat")) return;
  const toml::table* table = root.Table("heat");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "heat");
  ReadNumbers(reader, kHeatKeys, heat);
  reader.ReportUnknownKeys();
}

void ReadSensor(FileProblem& problem, TableReader& root, DeviceGeometry& device) {
  const toml::table* table = root.Table("sensor");
  if (table == nullptr) return;
  TableReader reader(problem, *table, "sensor");
  ReadNumbers(reader, kSensorKeys, device);
  reader.Numbers("sensor_noise_T", kSensorNoise_T, device.sensor_noise_T);
  reader.ReportUnknownKeys();
}

// Scales `values` to length 1.
void ReadUnit(FileProblem& problem, TableReader& reader, const char* key, std::span<double> values) {
  reader.Numbers(key, kDirection, values);
  if (!problem.ok()) return;
  double square = 0;
  for (const double value : values) square += value * value;
  const double length = std::sqrt(square);
  if (!(std::abs(length - 1) <= kUnitTolerance)) {
    problem.Report(reader.table().get(key), reader.NameOf(key) + " has length " + std::to_string(length) +
                                                "; must be a unit vector or quaternion (length 1)");
    return;
  }
  for (double& value : values) value /= length;
}

void ReadSensorPlaces(FileProblem& problem, TableReader& root, DeviceGeometry& device) {
  const auto tables = root.Tables("sensors", base::kSensorCount, base::kSensorCount);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    TableReader reader(problem, *tables[i], "sensors[" + std::to_string(i) + "]");
    device.sensors[i].position_base_m = reader.Vector("position_base_m", kPosition_m);
    double q[4];
    ReadUnit(problem, reader, "orientation_base_sensor", q);
    device.sensors[i].orientation_base_sensor = {q[0], q[1], q[2], q[3]};
    reader.ReportUnknownKeys();
  }
}

void ReadCoils(FileProblem& problem, TableReader& root, DeviceGeometry& device) {
  const auto tables = root.Tables("coils", base::kCoilCount, base::kCoilCount);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    TableReader reader(problem, *tables[i], "coils[" + std::to_string(i) + "]");
    double axis[3];
    ReadUnit(problem, reader, "axis_base", axis);
    device.coils[i].axis_base = {axis[0], axis[1], axis[2]};
    device.coils[i].turns = reader.Integer("turns", kTurns);
    device.coils[i].layers = reader.Integer("layers", kLayers);
    ReadNumbers(reader, kCoilKeys, device.coils[i]);
    reader.ReportUnknownKeys();
  }
}

}  // namespace

base::Result<DeviceGeometry> ParseDevice(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  DeviceGeometry device;
  device.name = root.Text("name", kMaxNameBytes);
  ReadMagnet(problem, root, device.magnet);
  ReadSection(problem, root, "core", kCoreKeys, device);
  ReadSection(problem, root, "hull", kHullKeys, device);
  ReadSensor(problem, root, device);
  ReadSensorPlaces(problem, root, device);
  ReadCoils(problem, root, device);
  ReadSection(problem, root, "limits", kLimitKeys, device);
  ReadHeat(problem, *parsed, root, device.heat);
  root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  if (const std::string contradiction = GeometryProblem(device); !contradiction.empty()) {
    return base::Error{name + ": " + contradiction};
  }
  return device;
}

base::Result<DeviceGeometry> LoadDeviceFile(const std::string& path) {
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseDevice(*text, path);
}

double NibRadius_m(const MagnetGeometry& magnet) {
  constexpr double kLongest_m = 0.003;
  const double half_m = magnet.shape == base::MagnetShape::kSphere ? magnet.radius_m : magnet.half_height_m;
  const double nib_m = std::round(1e9 * (magnet.tip_offset_m - half_m)) / 1e9;
  return nib_m > 0 && nib_m <= kLongest_m ? nib_m : 0;
}

const DeviceGeometry& DefaultDevice() {
  static const DeviceGeometry device = ParsedBuiltIn(ParseDevice, kBuiltInDeviceText, "manifests/device/omni.toml");
  return device;
}

namespace {

constexpr Range kMarkPosition_m{-0.5, 0.5};
constexpr std::size_t kMaxMarkNameBytes = 64;

}  // namespace

base::Result<std::vector<Mark>> ParseMarks(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  std::vector<Mark> marks;
  const auto tables = root.Tables("marks", kMinMarks, kMaxMarks);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    TableReader reader(problem, *tables[i], "marks[" + std::to_string(i) + "]");
    Mark mark;
    mark.name = reader.Text("name", kMaxMarkNameBytes);
    mark.position_base_m = reader.Vector("position_base_m", kMarkPosition_m);
    reader.ReportUnknownKeys();
    marks.push_back(std::move(mark));
  }
  root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  return marks;
}

base::Result<std::vector<Mark>> LoadMarksFile(const std::string& path) {
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseMarks(*text, path);
}

const std::vector<Mark>& DefaultMarks() {
  static const std::vector<Mark> marks = ParsedBuiltIn(ParseMarks, kBuiltInMarksText, "manifests/device/marks.toml");
  return marks;
}

}  // namespace omni::config
