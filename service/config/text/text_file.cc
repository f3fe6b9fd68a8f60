#include "service/config/text/text_file.h"

#include "service/base/files/read_file.h"
#include "service/base/files/whole_file.h"

namespace omni::config {

base::Result<std::string> ReadTextFile(const std::string& path) { return base::ReadFile(path, kMaxSettingsBytes); }

base::Status WriteTextFile(const std::string& path, const std::string& text) {
  return base::WriteWholeFile(path, text, {.make_folder = true});
}

}  // namespace omni::config
