#include "service/config/files/alignment_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

constexpr double kGuessWeight = 0.25;

double Square(double x) noexcept { return x * x; }

constexpr std::string_view kPolicies[] = {"front-of-user", "calibrated", "off"};
constexpr std::string_view kYesNo[] = {"yes", "no"};
constexpr std::size_t kMaxRuntimeBytes = 127, kMaxSystemBytes = 255, kMaxMethodBytes = 31, kMaxDateBytes = 31;
constexpr Range kAnySpace{1, 2'147'483'647};
constexpr Range kSpacePosition_m{-100, 100};
constexpr Range kUnit{-1, 1};
constexpr Range kField_uT{-1000, 1000};

std::string VectorText(const base::Vec3& p) {
  return "[" + TomlFloat(p.x) + ", " + TomlFloat(p.y) + ", " + TomlFloat(p.z) + "]\n";
}

std::string QuatText(const base::Quat& q) {
  return "[" + TomlFloat(q.w) + ", " + TomlFloat(q.x) + ", " + TomlFloat(q.y) + ", " + TomlFloat(q.z) + "]\n";
}

base::Quat ReadQuat(TableReader& reader, const char* key) {
  double q[4];
  reader.Numbers(key, kUnit, q);
  return {q[0], q[1], q[2], q[3]};
}

void CheckUnit(FileProblem& problem, const toml::table& table, const std::string& name, const std::string& key,
               const base::Quat& q) {
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!problem.ok() || std::abs(norm - 1) < 1e-3) return;
  problem.Report(table.get(key), name + "." + key + " has length " + TomlFloat(norm) +
                                     "; must be a unit quaternion; measure it again: omni align");
}

// Older files do not have it, nor do entries whose space stayed where it was.
void ReadMeasured(TableReader& reader, const toml::table& table, AlignmentEntry& entry) {
  entry.measured_position_space_m = entry.position_space_m;
  entry.measured_orientation_space = entry.orientation_space;
  if (!table.contains("measured_position_space_m") && !table.contains("measured_orientation_space_wxyz")) return;
  entry.measured_position_space_m = reader.Vector("measured_position_space_m", kSpacePosition_m);
  entry.measured_orientation_space = ReadQuat(reader, "measured_orientation_space_wxyz");
}

void ReadDrift(TableReader& reader, const toml::table& table, AlignmentDrift& drift) {
  if (table.contains("starts")) drift.starts = reader.Integer("starts", {0, 1e6});
  if (table.contains("checked_mm")) drift.checked_m = 1e-3 * reader.Number("checked_mm", {0, 100'000});
  if (table.contains("per_start_mm")) drift.per_start_m = 1e-3 * reader.Number("per_start_mm", {0, 100'000});
  if (table.contains("checks")) drift.checks = reader.Integer("checks", {0, 1e6});
}

std::string DriftText(const AlignmentDrift& drift) {
  std::string text = "starts = " + std::to_string(drift.starts) + "\n";
  if (drift.checked_m > 0) text += "checked_mm = " + TomlFloat(1e3 * drift.checked_m) + "\n";
  if (drift.checks == 0) return text;
  return text + "per_start_mm = " + TomlFloat(1e3 * drift.per_start_m) + "\nchecks = " + std::to_string(drift.checks) +
         "\n";
}

AlignmentEntry ReadEntry(FileProblem& problem, const toml::table& table, const std::string& name) {
  TableReader reader(problem, table, name);
  AlignmentEntry entry;
  entry.runtime = reader.Text("runtime", kMaxRuntimeBytes);
  entry.system = reader.Text("system", kMaxSystemBytes);
  entry.space = reader.Integer("space", kAnySpace);
  entry.position_space_m = reader.Vector("position_space_m", kSpacePosition_m);
  entry.orientation_space = ReadQuat(reader, "orientation_space_wxyz");
  entry.method = reader.Text("method", kMaxMethodBytes);
  entry.date = reader.Text("date", kMaxDateBytes);
  entry.samples = reader.Integer("samples", {0, 1e6});
  entry.rms_mm = reader.Number("rms_mm", {0, 1000});
  entry.expected_error_mm = reader.Number("expected_error_mm", {0, 1000});
  entry.rotation_deg = reader.Number("rotation_deg", {0, 180});
  entry.recentred = reader.Integer("recentred", {0, 1e9});
  ReadMeasured(reader, table, entry);
  entry.doubtful = reader.Choice("doubtful", kYesNo, "no") == "yes";
  if (table.contains("field_base_uT")) entry.field_base_T = 1e-6 * reader.Vector("field_base_uT", kField_uT);
  entry.base_moved = reader.Choice("base_moved", kYesNo, "no") == "yes";
  ReadDrift(reader, table, entry.drift);
  if (table.contains("used")) entry.used = reader.Text("used", kMaxDateBytes);
  reader.ReportUnknownKeys();
  CheckUnit(problem, table, name, "orientation_space_wxyz", entry.orientation_space);
  if (entry.measured_orientation_space != entry.orientation_space) {
    CheckUnit(problem, table, name, "measured_orientation_space_wxyz", entry.measured_orientation_space);
  }
  return entry;
}

}  // namespace

double ErrorNow_m(double expected_error_m, const AlignmentDrift& drift) noexcept {
  return std::sqrt(Square(std::max(expected_error_m, drift.checked_m)) + drift.starts * Square(drift.per_start_m));
}

bool HasDrifted(double expected_error_m, const AlignmentDrift& drift) noexcept {
  return ErrorNow_m(expected_error_m, drift) > std::max(kMostAlignmentError_m, kMostAlignmentGrowth * expected_error_m);
}

AlignmentDrift DriftAfterCheck(AlignmentDrift drift, double offset_m, double expected_error_m,
                               bool corrected) noexcept {
  if (drift.starts > 0) {
    const double known_m = std::max(expected_error_m, drift.checked_m);
    const double seen = std::max(0.0, Square(offset_m) - Square(known_m) - Square(kCheckError_m)) / drift.starts;
    const double weight = kGuessWeight + drift.checks;
    drift.per_start_m = std::sqrt((weight * Square(drift.per_start_m) + seen) / (weight + 1));
    ++drift.checks;
  }
  drift.starts = 0;
  drift.checked_m = corrected ? kCheckError_m : offset_m;
  return drift;
}

const char* PolicyName(UncalibratedPolicy policy) { return kPolicies[static_cast<std::size_t>(policy)].data(); }

base::Result<AlignmentFile> ParseAlignments(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  const int format = root.Integer("format", {1, 1000});
  if (problem.ok() && format != kAlignmentFormat) {
    problem.Report(parsed->get("format"), "format = " + std::to_string(format) + " is not known, this version reads " +
                                              std::to_string(kAlignmentFormat) +
                                              "; install the Omni version that wrote it, or move the file away");
  }
  if (!problem.ok()) return base::Error{problem.message()};
  AlignmentFile file;
  const std::string policy = root.Choice("placement", kPolicies, kPolicies[0]);
  for (std::size_t i = 0; i < std::size(kPolicies); ++i) {
    if (policy == kPolicies[i]) file.uncalibrated = static_cast<UncalibratedPolicy>(i);
  }
  if (parsed->contains("alignments")) {
    const auto tables = root.Tables("alignments", 0, kMaxAlignments);
    for (std::size_t i = 0; i < tables.size(); ++i) {
      file.entries.push_back(ReadEntry(problem, *tables[i], "alignments[" + std::to_string(i) + "]"));
    }
  }
  root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  return file;
}

base::Result<AlignmentFile> LoadAlignmentFile(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return AlignmentFile{};
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseAlignments(*text, path);
}

std::string WriteAlignments(const AlignmentFile& file) {
  std::string text = "# Where the base stands in the spaces of headsets, written by omnid for omni align.\n";
  text += "format = " + std::to_string(kAlignmentFormat) + "\n";
  text += std::string("placement = \"") + PolicyName(file.uncalibrated) + "\"\n";
  for (const AlignmentEntry& entry : file.entries) {
    text += "\n[[alignments]]\nruntime = " + TomlText(entry.runtime) + "\nsystem = " + TomlText(entry.system) + "\n";
    text += "space = " + std::to_string(entry.space) + "\n";
    text += "position_space_m = " + VectorText(entry.position_space_m);
    text += "orientation_space_wxyz = " + QuatText(entry.orientation_space);
    text += "method = " + TomlText(entry.method) + "\ndate = " + TomlText(entry.date) + "\n";
    text += "samples = " + std::to_string(entry.samples) + "\nrms_mm = " + TomlFloat(entry.rms_mm) + "\n";
    text += "expected_error_mm = " + TomlFloat(entry.expected_error_mm) + "\n";
    text +=
        "rotation_deg = " + TomlFloat(entry.rotation_deg) + "\nrecentred = " + std::to_string(entry.recentred) + "\n";
    if (entry.doubtful) text += "doubtful = \"yes\"\n";
    if (entry.field_base_T) text += "field_base_uT = " + VectorText(1e6 * *entry.field_base_T);
    if (entry.base_moved) text += "base_moved = \"yes\"\n";
    text += DriftText(entry.drift);
    if (!entry.used.empty()) text += "used = " + TomlText(entry.used) + "\n";
    if (entry.recentred == 0) continue;
    text += "measured_position_space_m = " + VectorText(entry.measured_position_space_m);
    text += "measured_orientation_space_wxyz = " + QuatText(entry.measured_orientation_space);
  }
  return text;
}

}  // namespace omni::config
