// Is there an OpenXR runtime below the layer?
#include "service/base/files/read_file.h"
#include "service/tools/common/files.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

constexpr std::size_t kMaxOsReleaseBytes = 64 * 1024;
constexpr const char* kRuntimeFix =
    "install a runtime (Monado, WiVRn, SteamVR) and make it active, or set XR_RUNTIME_JSON to its manifest";

// [os-release(5)] ID=debian, VERSION_ID="12"
bool IsDebian12(const Surroundings& surroundings) {
  const base::Result<std::string> text = base::ReadFile(surroundings.System("/etc/os-release"), kMaxOsReleaseBytes);
  if (!text.ok()) return false;
  const std::string lines = "\n" + *text + "\n";
  return lines.find("\nID=debian\n") != std::string::npos && lines.find("\nVERSION_ID=\"12\"\n") != std::string::npos;
}

std::string NoRuntimeFix(const Surroundings& surroundings) {
  if (!IsDebian12(surroundings)) return kRuntimeFix;
  return std::string(kRuntimeFix) + "; Debian 12 has no package of one: take WiVRn's Flatpak, SteamVR, or Debian 13";
}

}  // namespace

Finding LookForRuntime(const Surroundings& surroundings) {
  const std::filesystem::path file = ActiveRuntime(surroundings);
  if (file.empty())
    return {Verdict::kFail, "no active_runtime.json is found and XR_RUNTIME_JSON is not set",
            NoRuntimeFix(surroundings)};
  const base::Result<std::string> text = ReadJsonFile(file.string(), kManifestJson);
  if (!text.ok()) return {Verdict::kFail, text.error(), kRuntimeFix};
  const nlohmann::json document = nlohmann::json::parse(*text);
  const nlohmann::json::json_pointer at("/runtime/library_path");
  if (!document.is_object() || !document.contains(at) || !document[at].is_string()) {
    return {Verdict::kFail, file.string() + " is not a runtime manifest with runtime.library_path", kRuntimeFix};
  }
  std::error_code error;
  const std::filesystem::path real = std::filesystem::canonical(file, error);  // the active file is often a link
  const std::string library = ResolveLibrary(error ? file : real, document[at].get<std::string>());
  if (library.find('/') != std::string::npos && !std::filesystem::exists(library, error)) {
    return {Verdict::kFail, file.string() + ": " + library + " does not exist", kRuntimeFix};
  }
  return {Verdict::kOk, file.string() + " -> " + library, {}};
}

}  // namespace omni::tools
