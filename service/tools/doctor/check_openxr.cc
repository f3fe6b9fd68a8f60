// Do OpenXR's loader, its runtime and our layer work together?
#include <algorithm>

#include "service/base/files/whole_file.h"
#include "service/tools/common/files.h"
#include "service/tools/doctor/elf_file.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {

// Does the OpenXR loader find the layer's manifest, and is it one that the loader does not skip?

namespace {

constexpr const char* kInstall =
    "install the layer (cmake --install), or for a build tree set "
    "XR_API_LAYER_PATH=<build>/share/openxr/1/api_layers/explicit.d";

}  // namespace

Finding LookForLayer(const Surroundings& surroundings) {
  std::vector<LayerManifest> ours = FindLayerManifests(surroundings);
  ours.erase(std::remove_if(ours.begin(), ours.end(), [](const LayerManifest& m) { return !IsOurs(m); }), ours.end());
  if (ours.empty()) {
    std::string searched;
    for (const auto& folder : LayerFolders(surroundings, false)) {
      searched += (searched.empty() ? "" : ", ") + folder.string();
    }
    return {Verdict::kFail, std::string("no manifest names ") + kLayerName + " (searched " + searched + ")", kInstall};
  }
  for (const LayerManifest& manifest : ours) {
    if (manifest.problem.empty()) continue;
    return {Verdict::kFail, manifest.file.string() + " is skipped by the loader: " + manifest.problem,
            "install the layer again: its manifest is generated, not edited"};
  }
  return {Verdict::kOk, ours[0].file.string() + (ours[0].implicit ? " (implicit)" : " (explicit)"), {}};
}

// Can the layer's library be opened, and is it a layer?
Finding CheckLayerLibrary(const Surroundings& surroundings) {
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    if (manifest.name != kLayerName || !manifest.problem.empty()) continue;
    if (const std::string problem = LibraryProblem(manifest.library, manifest.negotiate); !problem.empty()) {
      return {Verdict::kFail, manifest.file.string() + ": " + problem,
              "build or install the layer again (target XrApiLayer_omni)"};
    }
    return {Verdict::kOk, manifest.library + " opens and exports " + manifest.negotiate, {}};
  }
  return {Verdict::kFail, "no valid manifest names a library", "fix \"layer manifest\" first"};
}

// Does an application without any knowledge of Omni get the layer?
Finding CheckEnabledLayers(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  const std::vector<std::string> names = EnabledByVariable(surroundings);
  if (std::find(names.begin(), names.end(), kLayerName) != names.end()) {
    return {Verdict::kOk, "XR_ENABLE_API_LAYERS names it", {}};
  }
  for (const LayerManifest& manifest : manifests) {
    if (manifest.name != kLayerName || !manifest.implicit) continue;
    if (IsUsable(manifest, surroundings)) {
      const auto others = LoadersOf32Bit(surroundings);
      if (others.empty()) return {Verdict::kOk, "implicit: every application gets it", {}};
      return {Verdict::kWarn,
              "implicit: every application gets it, and 32-bit ones do not start: " + others[0].string() +
                  " cannot load a 64-bit layer",
              "start 32-bit applications with " + manifest.disable_environment +
                  "=1, or name the layer for single applications: omni layer disable"};
    }
    if (surroundings.HasVariable(manifest.disable_environment)) {
      return {Verdict::kWarn, manifest.disable_environment + " is set: no application gets the layer",
              "unset " + manifest.disable_environment};
    }
  }
  return {Verdict::kWarn, "the layer is not enabled: only applications that ask for it by name get it",
          std::string("export XR_ENABLE_API_LAYERS=") + kLayerName + ", or for all applications: omni layer enable",
          "omni layer enable"};
}

// Is there an OpenXR runtime below the layer?

namespace {

constexpr std::size_t kMaxOsReleaseBytes = 64 * 1024;
constexpr const char* kRuntimeFix =
    "install a runtime (Monado, WiVRn, SteamVR) and make it active, or set XR_RUNTIME_JSON to its manifest";

// [os-release(5)] ID=debian, VERSION_ID="12"
bool IsDebian12(const Surroundings& surroundings) {
  const base::Result<std::string> text = base::ReadFile(surroundings.SystemPath("/etc/os-release"), kMaxOsReleaseBytes);
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
