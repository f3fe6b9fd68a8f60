#include "service/tools/track/track.h"

#include <cmath>
#include <cstdio>

#include "service/config/files/array_file.h"
#include "service/config/files/device_file.h"
#include "service/config/text/text_file.h"
#include "service/magnetics/nominal.h"
#include "service/tools/track/track_table.h"

namespace omni::tools {
namespace {

constexpr double kPositionMax_m = 20;
constexpr double kCurrentMax_A = 1000;
constexpr double kUnitTolerance = 1e-2;
constexpr const char* kCurrentColumns[] = {"i0_A", "i1_A", "i2_A"};

using Columns = std::array<TrackTable::UnitColumn, 3>;

base::Result<Columns> FieldColumns(const TrackTable& table) {
  Columns columns;
  const char* stems[] = {"bx", "by", "bz"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto column = table.FieldColumn(stems[i]);
    if (!column.ok()) return base::Error{column.error()};
    columns[i] = *column;
    if (columns[i].unit != columns[0].unit) {
      return base::Error{table.path() + ":1: bx is in " + columns[0].unit + " but " + stems[i] + " in " +
                         columns[i].unit + "; use one unit"};
    }
  }
  return columns;
}

// Appends the row to its pose; empty: fine.
std::string AddRow(const TrackTable& table, std::size_t row, const Columns& columns, std::size_t sensor_count,
                   std::vector<std::vector<bool>>& seen, Recording& recording) {
  const auto pose = table.Count(row, "pose");
  if (!pose.ok()) return pose.error();
  const auto sensor = table.Count(row, "sensor");
  if (!sensor.ok()) return sensor.error();
  if (*sensor >= sensor_count) {
    return table.Where(row) + "sensor " + std::to_string(*sensor) + " does not exist: the device has " +
           std::to_string(sensor_count) + " sensors, numbered from 0; use the recording's own device file";
  }
  if (recording.poses.empty() || recording.poses.back().number != *pose) {
    recording.poses.push_back({.number = *pose, .field_sensor_T = std::vector<base::Vec3>(sensor_count)});
    seen.emplace_back(sensor_count, false);
  }
  if (seen.back()[*sensor]) {
    return table.Where(row) + "sensor " + std::to_string(*sensor) + " of pose " + std::to_string(*pose) +
           " appears twice; remove one, and keep the rows of a pose together";
  }
  seen.back()[*sensor] = true;
  double field_T[3];
  for (std::size_t i = 0; i < 3; ++i) {
    field_T[i] = columns[i].factor * table.At(row, columns[i].column);
    if (!(std::abs(field_T[i]) <= kFieldMax_T)) {
      return table.Where(row) + table.names()[columns[i].column] + " means " + std::to_string(field_T[i]) +
             " T, more than " + std::to_string(kFieldMax_T) + " T; is the column's unit wrong?";
    }
  }
  recording.poses.back().field_sensor_T[*sensor] = {field_T[0], field_T[1], field_T[2]};
  for (std::size_t k = 0; recording.has_currents && k < std::size(kCurrentColumns); ++k) {
    const double current_A = table.At(row, kCurrentColumns[k]);
    if (!(std::abs(current_A) <= kCurrentMax_A)) {
      return table.Where(row) + kCurrentColumns[k] + " = " + std::to_string(current_A) + "; must be in [-1000, 1000]";
    }
    recording.poses.back().current_A[k] = current_A;
  }
  return {};
}

// Readings smaller than the sensors' noise everywhere carry no pose: most likely a unit is wrong.
std::string FaintnessProblem(const std::string& path, const Recording& recording, const base::Calibration& array) {
  double square = 0, count = 0;
  for (const RecordedPose& pose : recording.poses) {
    for (const base::Vec3& B : pose.field_sensor_T) square += B.x * B.x + B.y * B.y + B.z * B.z;
    count += 3 * static_cast<double>(pose.field_sensor_T.size());
  }
  double noise_square = 0;
  for (const double noise_T : array.sensor_noise_T) noise_square += noise_T * noise_T / 3;
  const double rms_T = std::sqrt(square / count), noise_T = std::sqrt(noise_square);
  if (rms_T > noise_T) return {};
  char text[160];
  std::snprintf(text, sizeof(text), "readings are %.3g T rms, below the sensors' noise of %.3g T; is a unit wrong?",
                rms_T, noise_T);
  return path + ": " + text;
}

}  // namespace

base::Result<Recording> ReadRecording(const std::string& path, const base::Calibration& array) {
  const auto table = TrackTable::Read(path);
  if (!table.ok()) return base::Error{table.error()};
  if (const auto there = table->Require({"pose", "sensor"}); !there.ok()) return base::Error{there.error()};
  const auto columns = FieldColumns(*table);
  if (!columns.ok()) return base::Error{columns.error()};
  Recording recording;
  std::size_t currents = 0;
  for (const char* name : kCurrentColumns) currents += table->Has(name) ? 1 : 0;
  if (currents != 0 && currents != std::size(kCurrentColumns)) {
    return base::Error{path + ":1: has only " + std::to_string(currents) +
                       " of the columns i0_A, i1_A, i2_A; give all three or none"};
  }
  recording.has_currents = currents != 0;
  if (recording.has_currents) {
    const auto there = table->Require({std::begin(kCurrentColumns), std::end(kCurrentColumns)});
    if (!there.ok()) return base::Error{there.error()};
  }
  std::vector<std::vector<bool>> seen;
  for (std::size_t row = 0; row < table->rows(); ++row) {
    const std::string problem = AddRow(*table, row, *columns, array.sensors.size(), seen, recording);
    if (!problem.empty()) return base::Error{problem};
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t sensor = 0; sensor < seen[i].size(); ++sensor) {
      if (seen[i][sensor]) continue;
      return base::Error{path + ": pose " + std::to_string(recording.poses[i].number) + " lacks sensor " +
                         std::to_string(sensor) + " of " + std::to_string(array.sensors.size()) +
                         "; every pose needs every sensor once, its rows together"};
    }
  }
  if (const std::string problem = FaintnessProblem(path, recording, array); !problem.empty()) {
    return base::Error{problem};
  }
  return recording;
}

base::Result<Truth> ReadTruth(const std::string& path) {
  const auto table = TrackTable::Read(path);
  if (!table.ok()) return base::Error{table.error()};
  if (const auto there = table->Require({"pose", "ux", "uy", "uz"}); !there.ok()) return base::Error{there.error()};
  Columns columns;
  const char* stems[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto column = table->LengthColumn(stems[i]);
    if (!column.ok()) return base::Error{column.error()};
    columns[i] = *column;
  }
  Truth truth;
  for (std::size_t row = 0; row < table->rows(); ++row) {
    const auto pose = table->Count(row, "pose");
    if (!pose.ok()) return base::Error{pose.error()};
    double p_m[3];
    for (std::size_t i = 0; i < 3; ++i) {
      p_m[i] = columns[i].factor * table->At(row, columns[i].column);
      if (!(std::abs(p_m[i]) <= kPositionMax_m)) {
        return base::Error{table->Where(row) + table->names()[columns[i].column] + " means " + std::to_string(p_m[i]) +
                           " m, more than 20 m; is the column's unit wrong?"};
      }
    }
    const base::Vec3 u{table->At(row, "ux"), table->At(row, "uy"), table->At(row, "uz")};
    const double length = std::hypot(u.x, u.y, u.z);
    if (!(std::abs(length - 1) <= kUnitTolerance)) {
      return base::Error{table->Where(row) + "ux, uy, uz have length " + std::to_string(length) +
                         "; must be a unit vector (length 1)"};
    }
    const TruePose true_pose{{p_m[0], p_m[1], p_m[2]}, {u.x / length, u.y / length, u.z / length}};
    if (!truth.emplace(*pose, true_pose).second) {
      return base::Error{table->Where(row) + "pose " + std::to_string(*pose) + " appears twice; remove one"};
    }
  }
  return truth;
}

std::string WriteRecording(const Recording& recording) {
  std::string text = "pose,sensor,bx_T,by_T,bz_T";
  text += recording.has_currents ? ",i0_A,i1_A,i2_A\n" : "\n";
  char line[256];
  for (const RecordedPose& pose : recording.poses) {
    for (std::size_t i = 0; i < pose.field_sensor_T.size(); ++i) {
      const base::Vec3& B = pose.field_sensor_T[i];
      std::snprintf(line, sizeof(line), "%zu,%zu,%.9g,%.9g,%.9g", pose.number, i, B.x, B.y, B.z);
      text += line;
      for (std::size_t k = 0; recording.has_currents && k < pose.current_A.size(); ++k) {
        std::snprintf(line, sizeof(line), ",%.9g", pose.current_A[k]);
        text += line;
      }
      text += "\n";
    }
  }
  return text;
}

std::string WriteTruth(const Truth& truth) {
  std::string text = "pose,x_m,y_m,z_m,ux,uy,uz\n";
  char line[256];
  for (const auto& [number, pose] : truth) {
    const base::Vec3 &p = pose.position_base_m, &u = pose.axis_base;
    std::snprintf(line, sizeof(line), "%zu,%.10g,%.10g,%.10g,%.10g,%.10g,%.10g\n", number, p.x, p.y, p.z, u.x, u.y,
                  u.z);
    text += line;
  }
  return text;
}

base::Result<base::Calibration> LoadTrackDevice(const std::string& path) {
  const auto text = config::ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  if (!config::IsArrayText(*text)) {
    const auto device = config::ParseDevice(*text, path);
    if (!device.ok()) {
      return base::Error{
          device.error() +
          " (read as the device file of an Omni base; other arrays start with format = \"omni-array 1\")"};
    }
    return magnetics::NominalCalibration(*device);
  }
  auto file = config::ParseArray(*text, path);
  if (!file.ok()) return base::Error{file.error()};
  base::Calibration array = std::move(file->calibration);
  if (!(array.moment_Am2 > 0)) array.moment_Am2 = magnetics::MomentOf(array.magnet);
  magnetics::AddWindings(file->coils, array);
  return array;
}

}  // namespace omni::tools
