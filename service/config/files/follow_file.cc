#include "service/config/files/follow_file.h"

#include <cmath>
#include <filesystem>

#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

constexpr std::size_t kMaxFollowBytes = 255;  // XR_MAX_PATH_LENGTH without its end
constexpr Range kMount_m{-10, 10};
constexpr Range kMountUnit{-1, 1};

}  // namespace

base::Result<FollowSettings> ParseFollow(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  FollowSettings settings;
  if (const toml::table* table = root.Table("base")) {
    TableReader reader(problem, *table, "base");
    settings.follows = reader.Text("follows", kMaxFollowBytes);
    settings.position_source_m = reader.Vector("position_source_m", kMount_m);
    double q[4];
    reader.Numbers("orientation_source_wxyz", kMountUnit, q);
    reader.ReportUnknownKeys();
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (problem.ok() && !(std::abs(norm - 1) < 1e-3)) {
      problem.Report(table->get("orientation_source_wxyz"),
                     "base.orientation_source_wxyz has length " + TomlFloat(norm) +
                         "; must be a unit quaternion; measure it again: omni follow PATH --mount");
    }
    settings.orientation_source = {q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
  }
  root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  return settings;
}

base::Result<std::optional<FollowSettings>> LoadFollowFile(const std::string& path) {
  std::error_code error;
  if (path.empty() || (!std::filesystem::exists(path, error) && !error)) return std::optional<FollowSettings>();
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  base::Result<FollowSettings> settings = ParseFollow(*text, path);
  if (!settings.ok()) return base::Error{settings.error()};
  return std::optional(std::move(*settings));
}

std::string WriteFollow(const FollowSettings& settings) {
  const base::Vec3& p = settings.position_source_m;
  const base::Quat& q = settings.orientation_source;
  return "# What the base follows, written by omni follow; `omni follow --off` removes it.\n[base]\nfollows = " +
         TomlText(settings.follows) + "\nposition_source_m = [" + TomlFloat(p.x) + ", " + TomlFloat(p.y) + ", " +
         TomlFloat(p.z) + "]\norientation_source_wxyz = [" + TomlFloat(q.w) + ", " + TomlFloat(q.x) + ", " +
         TomlFloat(q.y) + ", " + TomlFloat(q.z) + "]\n";
}

}  // namespace omni::config
