#include "service/tools/common/whole_file.h"

#include <cerrno>

#include "service/base/files/whole_file.h"

namespace omni::tools {

base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite) {
  const int error = base::PutWholeFile(path, {content}, {.replace = overwrite});
  if (error == 0) return base::Ok{};
  if (error == EEXIST) return base::Error{path + ": already exists; choose another name, or replace it with --force"};
  return base::Error{base::WriteProblem(path, error)};
}

}  // namespace omni::tools
