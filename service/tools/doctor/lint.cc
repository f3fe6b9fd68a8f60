// Rules for the OpenXR layers of this machine.
#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "service/tools/doctor/elf_file.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

// All objections of a rule as the single finding of a diagnosis.
class Objections {
 public:
  void Add(Verdict verdict, const std::string& what, const std::string& fix) {
    if (verdict > sum_.verdict) sum_.verdict = verdict;
    sum_.what += (sum_.what.empty() ? "" : "; ") + what;
    if (sum_.fix.find(fix) == std::string::npos) sum_.fix += (sum_.fix.empty() ? "" : "; ") + fix;
  }
  // All of them with the worst verdict; `ok` when there is none.
  Finding Sum(const std::string& ok) const { return sum_.what.empty() ? Finding{Verdict::kOk, ok, {}} : sum_; }

 private:
  Finding sum_;
};

}  // namespace

// Rule "BadInstallation": the loader accepts every manifest, its library exists, and XR_ENABLE_API_LAYERS names only
// installed layers. [OpenXR-API-Layers-GUI, BadInstallationLinter]

namespace {

constexpr const char* kReinstall = "install that layer again, or remove its manifest";

}  // namespace

Finding LintBadInstallation(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  Objections objections;
  for (const LayerManifest& manifest : manifests) {
    if (!manifest.problem.empty()) {
      objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                     manifest.file.string() + " is skipped by the loader: " + manifest.problem, kReinstall);
    } else if (!LibraryIsThere(manifest)) {
      objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                     manifest.file.string() + " is skipped by the loader: " + manifest.library + " does not exist",
                     kReinstall);
    }
  }
  // A name without a layer makes every xrCreateInstance fail with XR_ERROR_API_LAYER_NOT_PRESENT.
  for (const std::string& name : EnabledByVariable(surroundings)) {
    if (FoundByName(manifests, name, surroundings)) continue;
    objections.Add(
        Verdict::kFail,
        "XR_ENABLE_API_LAYERS names " + name + ", which the loader does not find: no OpenXR application starts",
        "remove the name from XR_ENABLE_API_LAYERS, or install that layer (XR_API_LAYER_PATH replaces the "
        "standard folders: list them too)");
  }
  return objections.Sum(std::to_string(manifests.size()) + " layers are installed correctly");
}

// Rule "DisabledByEnvironment": an implicit layer can be disabled, is not disabled now, and needs no further variable.
// The loader checks whether a variable is set, not its value. [OpenXR-API-Layers-GUI, DisabledByEnvironmentLinter]
Finding LintDisabledByEnvironment(const Surroundings& surroundings) {
  Objections objections;
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    if (!manifest.implicit || manifest.name.empty()) continue;
    const std::string who = manifest.name + " (" + manifest.file.string() + ")";
    if (manifest.disable_environment.empty()) {
      objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                     who + " has no disable_environment: the loader skips it because it could not be disabled",
                     "install that layer again, or remove its manifest");
    } else if (surroundings.HasVariable(manifest.disable_environment)) {
      objections.Add(Verdict::kWarn, who + " is disabled: " + manifest.disable_environment + " is set",
                     "unset " + manifest.disable_environment + " (its value does not matter)");
    } else if (!manifest.enable_environment.empty() && !surroundings.HasVariable(manifest.enable_environment)) {
      objections.Add(Verdict::kWarn, who + " needs " + manifest.enable_environment + ", which is not set",
                     "set " + manifest.enable_environment + " where its applications start");
    }
  }
  return objections.Sum("no implicit layer is disabled");
}

// Rule "Duplicates": of two manifests of the same kind that name the same layer, the loader uses the first it reads, in
// unspecified order. Debian's one manifest per architecture is not a duplicate. [OpenXR-API-Layers-GUI,
// DuplicatesLinter]
Finding LintDuplicates(const Surroundings& surroundings) {
  namespace fs = std::filesystem;
  Objections objections;
  std::set<fs::path> seen;  // a folder may be searched twice
  std::map<std::tuple<bool, std::string, std::string>, fs::path> first;
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    std::error_code error;
    const fs::path file = fs::weakly_canonical(manifest.file, error);
    if (!manifest.problem.empty() || !seen.insert(error ? manifest.file : file).second) continue;
    const base::Result<ElfFile> library = ReadElfFile(manifest.library);
    const std::string architecture = library.ok() ? library->architecture() : std::string();
    const auto [same, is_new] =
        first.emplace(std::tuple(manifest.implicit, manifest.name, architecture), manifest.file);
    if (is_new) continue;
    objections.Add(Verdict::kWarn,
                   std::string("two ") + (manifest.implicit ? "implicit" : "explicit") + " manifests name " +
                       manifest.name + ": " + same->second.string() + " and " + manifest.file.string() +
                       "; the loader uses only one of them",
                   "remove the one that you do not want");
  }
  return objections.Sum("no layer is installed twice");
}

// Rule "ExplicitLayerArchitectures": every application requests the layers named in XR_ENABLE_API_LAYERS, so each must
// be installed for every architecture that has an OpenXR loader; otherwise applications fail to start.
// [OpenXR-API-Layers-GUI, ExplicitLayerArchitecturesLinter]

namespace {

namespace fs = std::filesystem;

// Architecture -> a loader of it.
std::map<std::string, std::string> InstalledLoaders(const Surroundings& surroundings) {
  std::vector<fs::path> folders{surroundings.SystemPath("/usr/lib"), surroundings.SystemPath("/usr/lib64"),
                                surroundings.SystemPath("/usr/lib32"), surroundings.SystemPath("/usr/local/lib")};
  std::error_code error;
  for (fs::directory_iterator at(folders.front(), error), end; !error && at != end; at.increment(error))
    if (at->path().filename().string().find("-linux-") != std::string::npos) folders.push_back(at->path());
  std::map<std::string, std::string> loaders;
  for (const fs::path& folder : folders) {
    const std::string file = (folder / "libopenxr_loader.so.1").string();
    if (const auto loader = ReadElfFile(file); loader.ok()) loaders.emplace(loader->architecture(), file);
  }
  return loaders;
}

}  // namespace

Finding LintExplicitLayerArchitectures(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  const std::map<std::string, std::string> loaders = InstalledLoaders(surroundings);
  Objections objections;
  for (const std::string& name : EnabledByVariable(surroundings)) {
    std::set<std::string> available;
    for (const LayerManifest& manifest : manifests) {
      if (manifest.name != name || !manifest.problem.empty()) continue;
      if (const auto library = ReadElfFile(manifest.library); library.ok()) available.insert(library->architecture());
    }
    if (available.empty()) continue;  // rule "BadInstallation", or a bare name that dlopen finds
    for (const auto& [architecture, loader] : loaders) {
      if (available.count(architecture) != 0) continue;
      objections.Add(Verdict::kWarn,
                     name + " is enabled for all applications but not installed for " + architecture + " (" + loader +
                         "): applications of that architecture do not start",
                     "install the layer for " + architecture +
                         " too, or enable it as an implicit layer (omni layer enable) or in the application");
    }
  }
  return objections.Sum("every layer enabled by name is installed for the architecture of every loader");
}

// Rule "Ordering": some layers work only above or below certain others. Implicit layers are above those that are
// enabled by name; among implicit ones the order on Linux is unspecified. [OpenXR-API-Layers-GUI, OrderingLinter
// and its rules; what concerns our layer is ours]

namespace {

// Each is the name of a layer, or of an extension that a layer provides. Above: closer to the application.
struct OrderRule {
  const char* above;
  const char* below;
  const char* why;
};
constexpr const char* kHandClicking = "XR_APILAYER_FREDEMMOTT_HandTrackedCockpitClicking";
constexpr const char* kMotionCompensation = "XR_APILAYER_NOVENDOR_motion_compensation";
constexpr const char* kToolkit = "XR_APILAYER_MBUCCHIA_toolkit";
constexpr OrderRule kOrderRules[] = {
    {kLayerName, kMotionCompensation, "it moves the spaces in which the pen is placed"},
    {kLayerName, kHandClicking, "it does not pass suggested bindings on"},
    {kMotionCompensation, kHandClicking, "the two do not work in the other order"},
    {"XR_APILAYER_NOVENDOR_XRNeckSafer", kHandClicking, "the two do not work in the other order"},
    {"XR_APILAYER_FREDEMMOTT_OpenKneeboard", kMotionCompensation,
     "it changes the poses that the upper layer draws with"},
    {"XR_APILAYER_app_racelab_Overlay", kMotionCompensation, "it changes the poses that the upper layer draws with"},
    {kHandClicking, "XR_EXT_hand_tracking", "it needs the extension that the lower layer provides"},
    {kToolkit, "XR_EXT_hand_tracking", "it needs the extension that the lower layer provides"},
    {kToolkit, "XR_EXT_eye_gaze_interaction", "it needs the extension that the lower layer provides"},
};

struct Enabled {
  const LayerManifest* manifest;
  int place;  // 0: implicit; then the place in XR_ENABLE_API_LAYERS
};

std::vector<Enabled> EnabledLayers(const std::vector<LayerManifest>& manifests, const Surroundings& surroundings) {
  const std::vector<std::string> names = EnabledByVariable(surroundings);
  std::vector<Enabled> enabled;
  for (const LayerManifest& manifest : manifests) {
    if (!IsUsable(manifest, surroundings)) continue;
    const auto named = std::find(names.begin(), names.end(), manifest.name);
    if (manifest.implicit) {
      enabled.push_back({&manifest, 0});
    } else if (named != names.end()) {
      enabled.push_back({&manifest, 1 + static_cast<int>(named - names.begin())});
    }
  }
  return enabled;
}

bool Is(const LayerManifest& manifest, const char* what) {
  return manifest.name == what ||
         std::find(manifest.extensions.begin(), manifest.extensions.end(), what) != manifest.extensions.end();
}

}  // namespace

Finding LintOrdering(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  const std::vector<Enabled> enabled = EnabledLayers(manifests, surroundings);
  Objections objections;
  for (const OrderRule& rule : kOrderRules) {
    for (const Enabled& above : enabled) {
      for (const Enabled& below : enabled) {
        const std::string& upper = above.manifest->name;
        const std::string& lower = below.manifest->name;
        if (upper == lower || !Is(*above.manifest, rule.above) || !Is(*below.manifest, rule.below)) continue;
        if (above.place < below.place) continue;
        const bool by_chance = above.place == 0 && below.place == 0;
        objections.Add(Verdict::kWarn,
                       upper + (by_chance ? " is above " + lower + " only by chance: both are implicit"
                                          : " must be above " + lower + ": " + rule.why),
                       "list them in XR_ENABLE_API_LAYERS in this order: " + upper + ":" + lower +
                           (by_chance ? " (and disable the implicit manifests)" : ""));
      }
    }
  }
  return objections.Sum(std::to_string(enabled.size()) + " enabled layers are in a working order");
}

// Rule "SkippedByLoader": the loader uses every layer that it should use by its own rules.
// [OpenXR-API-Layers-GUI, SkippedByLoaderLinter]
Finding LintSkippedByLoader(const Surroundings& surroundings) {
  const LoaderAnswer& loader = surroundings.loader;
  if (!loader.asked) {
    return {Verdict::kOk, "no OpenXR loader is installed: applications bring their own", {}};
  }
  if (!loader.error.empty()) {
    return {Verdict::kFail, "the OpenXR loader cannot list the layers: " + loader.error,
            "fix the manifests above; with XR_LOADER_DEBUG=all the loader prints what it reads"};
  }
  Objections objections;
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    if (!IsUsable(manifest, surroundings)) continue;  // rules "BadInstallation" and "DisabledByEnvironment"
    if (std::find(loader.layers.begin(), loader.layers.end(), manifest.name) != loader.layers.end()) continue;
    objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                   manifest.name + " (" + manifest.file.string() + ") is skipped by the loader",
                   "start an application with XR_LOADER_DEBUG=all: the loader prints why");
  }
  return objections.Sum("the loader lists " + std::to_string(loader.layers.size()) + " layers, as expected");
}

}  // namespace omni::tools
