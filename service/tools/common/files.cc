#include "service/tools/common/files.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "service/base/files/read_file.h"
#include "service/base/files/whole_file.h"

namespace omni::tools {

base::Result<std::string> ReadJsonFile(const std::string& path, const base::JsonLimits& limits) {
  base::Result<std::string> text = base::ReadFile(path, limits.bytes);
  if (!text.ok()) return text;
  const base::Status checked = base::CheckJson(*text, limits);
  if (!checked.ok()) return base::Error{path + ": " + checked.error()};
  return text;
}

base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite) {
  const int error = base::PutWholeFile(path, {content}, {.replace = overwrite});
  if (error == 0) return base::Ok{};
  if (error == EEXIST) return base::Error{path + ": already exists; choose another name, or replace it with --force"};
  return base::Error{base::WriteProblem(path, error)};
}

std::string WriteText(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  return file ? std::string() : path + ": cannot be written (" + std::strerror(errno) + "); check the folder";
}

}  // namespace omni::tools
