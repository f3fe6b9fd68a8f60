#include "service/tools/common/json_file.h"

#include "service/base/files/read_file.h"

namespace omni::tools {

base::Result<std::string> ReadJsonFile(const std::string& path, const base::JsonLimits& limits) {
  base::Result<std::string> text = base::ReadFile(path, limits.bytes);
  if (!text.ok()) return text;
  const base::Status checked = base::CheckJson(*text, limits);
  if (!checked.ok()) return base::Error{path + ": " + checked.error()};
  return text;
}

}  // namespace omni::tools
