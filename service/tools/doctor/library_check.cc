#include "service/tools/doctor/library_check.h"

#include <dlfcn.h>

#include <filesystem>

namespace omni::tools {

std::string LibraryProblem(const std::string& library, const std::string& function) {
  std::error_code error;
  if (library.find('/') != std::string::npos && !std::filesystem::exists(library, error)) {
    return library + " does not exist";
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
