#include "service/config/alignment_file.h"

#include <cmath>
#include <filesystem>

#include "service/config/text_file.h"
#include "service/config/toml_reader.h"

namespace omni::config {
namespace {

constexpr std::string_view kPolicies[] = {"front-of-user", "calibrated", "off"};
constexpr std::string_view kYesNo[] = {"yes", "no"};
constexpr std::size_t kMaxRuntimeBytes = 127, kMaxSystemBytes = 255, kMaxMethodBytes = 31, kMaxDateBytes = 31;
constexpr Range kAnySpace{1, 2'147'483'647};
constexpr Range kSpacePosition_m{-100, 100};
constexpr Range kUnit{-1, 1};

// A basic string of TOML: names come from other programs.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

AlignmentEntry ReadEntry(FileProblem& problem, const toml::table& table, const std::string& name) {
  TableReader reader(problem, table, name);
  AlignmentEntry entry;
  entry.runtime = reader.Text("runtime", kMaxRuntimeBytes);
  entry.system = reader.Text("system", kMaxSystemBytes);
  entry.space = reader.Integer("space", kAnySpace);
  entry.position_space_m = reader.Vector("position_space_m", kSpacePosition_m);
  double q[4];
  reader.Numbers("orientation_space_wxyz", kUnit, q);
  entry.orientation_space = {q[0], q[1], q[2], q[3]};
  entry.method = reader.Text("method", kMaxMethodBytes);
  entry.date = reader.Text("date", kMaxDateBytes);
  entry.samples = reader.Integer("samples", {0, 1e6});
  entry.rms_mm = reader.Number("rms_mm", {0, 1000});
  entry.expected_error_mm = reader.Number("expected_error_mm", {0, 1000});
  entry.rotation_deg = reader.Number("rotation_deg", {0, 180});
  entry.recentred = reader.Integer("recentred", {0, 1e9});
  entry.doubtful = reader.Choice("doubtful", kYesNo, "no") == "yes";
  reader.Finish();
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (problem.ok() && !(std::abs(norm - 1) < 1e-3)) {
    problem.Report(table.get("orientation_space_wxyz"), name + ".orientation_space_wxyz has length " + TomlFloat(norm) +
                                                            "; must be a unit quaternion; align anew: omni align");
  }
  return entry;
}

}  // namespace

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
  root.Finish();
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
    const base::Quat& q = entry.orientation_space;
    const base::Vec3& p = entry.position_space_m;
    text += "\n[[alignments]]\nruntime = " + Quoted(entry.runtime) + "\nsystem = " + Quoted(entry.system) + "\n";
    text += "space = " + std::to_string(entry.space) + "\n";
    text += "position_space_m = [" + TomlFloat(p.x) + ", " + TomlFloat(p.y) + ", " + TomlFloat(p.z) + "]\n";
    text += "orientation_space_wxyz = [" + TomlFloat(q.w) + ", " + TomlFloat(q.x) + ", " + TomlFloat(q.y) + ", " +
            TomlFloat(q.z) + "]\n";
    text += "method = " + Quoted(entry.method) + "\ndate = " + Quoted(entry.date) + "\n";
    text += "samples = " + std::to_string(entry.samples) + "\nrms_mm = " + TomlFloat(entry.rms_mm) + "\n";
    text += "expected_error_mm = " + TomlFloat(entry.expected_error_mm) + "\n";
    text +=
        "rotation_deg = " + TomlFloat(entry.rotation_deg) + "\nrecentred = " + std::to_string(entry.recentred) + "\n";
    if (entry.doubtful) text += "doubtful = \"yes\"\n";
  }
  return text;
}

base::Status SaveAlignmentFile(const std::string& path, const AlignmentFile& file) {
  return WriteTextFile(path, WriteAlignments(file));
}

}  // namespace omni::config
