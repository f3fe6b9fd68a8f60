// Rule "Duplicates": of two manifests of the same kind that name the same layer, the loader uses the first it reads, in
// unspecified order. Debian's one manifest per architecture is not a duplicate. [OpenXR-API-Layers-GUI,
// DuplicatesLinter]
#include <map>
#include <set>
#include <tuple>

#include "service/tools/doctor/elf_file.h"
#include "service/tools/doctor/objections.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {

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

}  // namespace omni::tools
