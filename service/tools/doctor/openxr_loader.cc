#include "service/tools/doctor/openxr_manifests.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <sys/statvfs.h>

#include <cstdint>
#include <filesystem>

#include <openxr/openxr.h>

#include "service/tools/doctor/elf_file.h"

namespace omni::tools {
namespace {

constexpr const char* kLoader = "libopenxr_loader.so.1";
constexpr const char* kDebug = "XR_LOADER_DEBUG";

// Suppresses the loader's messages on stderr: the diagnoses report the same problems more clearly.
class SilencedLoader {
 public:
  SilencedLoader() {
    if (const char* value = std::getenv(kDebug)) {
      had_ = true;
      before_ = value;
    }
    ::setenv(kDebug, "none", 1);
  }
  ~SilencedLoader() { had_ ? ::setenv(kDebug, before_.c_str(), 1) : ::unsetenv(kDebug); }
  SilencedLoader(const SilencedLoader&) = delete;
  SilencedLoader& operator=(const SilencedLoader&) = delete;

 private:
  bool had_ = false;
  std::string before_;
};

}  // namespace

LoaderAnswer QueryLoader() {
  LoaderAnswer answer;
  const SilencedLoader quiet;
  void* library = ::dlopen(kLoader, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return answer;
  answer.asked = true;
  const auto enumerate =
      reinterpret_cast<PFN_xrEnumerateApiLayerProperties>(::dlsym(library, "xrEnumerateApiLayerProperties"));
  if (enumerate == nullptr) {
    answer.error = std::string(kLoader) + " has no xrEnumerateApiLayerProperties";
  } else {
    std::uint32_t count = 0;
    XrResult result = enumerate(0, &count, nullptr);
    std::vector<XrApiLayerProperties> layers(count, {XR_TYPE_API_LAYER_PROPERTIES, nullptr, {}, 0, 0, {}});
    if (XR_SUCCEEDED(result) && count > 0) result = enumerate(count, &count, layers.data());
    if (XR_FAILED(result)) answer.error = "xrEnumerateApiLayerProperties: XrResult " + std::to_string(result);
    for (std::uint32_t i = 0; answer.error.empty() && i < count; ++i) answer.layers.emplace_back(layers[i].layerName);
  }
  ::dlclose(library);
  return answer;
}

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
