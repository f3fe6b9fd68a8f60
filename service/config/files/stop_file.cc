#include "service/config/files/stop_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <ctime>

#include "service/base/files/whole_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

constexpr std::size_t kMaxBytes = 4096;

constexpr const char* kComment =
    "# Emergency stop. While this file is here, omnid starts without force. `omni stop --release` removes it.\n";

bool IsNothing(const std::string& path, struct stat& there) {
  return path.empty() || (::lstat(path.c_str(), &there) != 0 && (errno == ENOENT || errno == ENOTDIR));
}

}  // namespace

std::optional<StopRecord> FindStop(const std::string& path) {
  struct stat there {};
  if (IsNothing(path, there)) return std::nullopt;
  StopRecord record{.by = {}, .at = IsoTime(there.st_mtime)};
  if (!S_ISREG(there.st_mode)) return record;
  const base::Result<std::string> text = base::ReadFile(path, kMaxBytes);
  if (!text.ok()) return record;
  const base::Result<toml::table> table = ParseToml(*text, path);
  if (!table.ok()) return record;
  record.by = (*table)["by"].value_or(record.by);
  record.at = (*table)["at"].value_or(record.at);
  return record;
}

std::string IsoTime(std::int64_t unix_s) {
  const auto seconds = static_cast<std::time_t>(unix_s);
  std::tm utc{};
  char text[32] = "";
  if (::gmtime_r(&seconds, &utc) == nullptr) return {};
  return std::string(text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc));
}

base::Status KeepStop(const std::string& path, const StopRecord& record) {
  struct stat there {};
  if (path.empty()) return base::Error{"there is no folder for it: set HOME or XDG_STATE_HOME"};
  if (!IsNothing(path, there)) return base::Ok{};
  return base::WriteWholeFile(path, kComment + ("by = " + TomlText(record.by) + "\nat = " + TomlText(record.at) + "\n"),
                              {.make_folder = true});
}

base::Status RemoveStop(const std::string& path) {
  if (path.empty()) return base::Ok{};
  return base::RemoveWholeFile(path);
}

}  // namespace omni::config
