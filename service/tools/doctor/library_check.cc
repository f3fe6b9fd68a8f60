#include "service/tools/doctor/library_check.h"

#include <dlfcn.h>
#include <sys/statvfs.h>

#include <filesystem>

namespace omni::tools {

std::string LibraryProblem(const std::string& library, const std::string& function) {
  std::error_code error;
  if (library.find('/') != std::string::npos && !std::filesystem::exists(library, error)) {
    return library + " does not exist";
  }
  struct statvfs mount {};
  if (::statvfs(library.c_str(), &mount) == 0 && (mount.f_flag & ST_NOEXEC) != 0) {
    return library + " lies on a file system that is mounted noexec: no application can load it";
  }
  void* handle = ::dlopen(library.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (handle == nullptr) {
    const char* why = ::dlerror();
    return "cannot be opened: " + std::string(why != nullptr ? why : library.c_str());
  }
  const bool has = ::dlsym(handle, function.c_str()) != nullptr;
  ::dlclose(handle);
  return has ? std::string() : library + " does not export " + function;
}

}  // namespace omni::tools
