// The OpenXR loader's search for layers and runtimes, done again: same folders, same order, same rules.
// [OpenXR loader design, "Desktop Layer Discovery"; seen with Debian's loader 1.0.20]
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

struct LayerManifest {
  std::filesystem::path file;
  bool implicit = false;
  std::string problem;  // why the loader skips it; the rest is then as far as it was read
  std::string name;
  std::string library;  // as the loader opens it: absolute, or a bare name that dlopen searches
  std::string negotiate = "xrNegotiateLoaderApiLayerInterface";
  std::string disable_environment;
  std::string enable_environment;
  std::string version;                  // implementation_version
  std::vector<std::string> extensions;  // that it brings: the names in instance_extensions
};

// Folders in search order, whether they exist or not.
std::vector<std::filesystem::path> LayerFolders(const Surroundings& surroundings, bool implicit);

// Every *.json of those folders: implicit layers first.
std::vector<LayerManifest> FindLayerManifests(const Surroundings& surroundings);

LayerManifest ReadLayerManifest(const std::filesystem::path& file, bool implicit);

// Ours is known by its layer's name; a broken one by its file's.
bool IsOurs(const LayerManifest& manifest);

// The names in XR_ENABLE_API_LAYERS, in order.
std::vector<std::string> EnabledByVariable(const Surroundings& surroundings);

// Whether a name in XR_ENABLE_API_LAYERS is one that the loader finds. Debian's loader 1.0.20 looks among implicit
// layers only where there is an explicit one too.
bool FoundByName(const std::vector<LayerManifest>& manifests, const std::string& name,
                 const Surroundings& surroundings);

// The library is there, as far as that can be told without opening it: a bare name is dlopen's to find.
bool LibraryIsThere(const LayerManifest& manifest);

// The loader would use it: sound, its library there, and if implicit neither disabled nor waiting to be enabled.
bool IsUsable(const LayerManifest& manifest, const Surroundings& surroundings);

// The manifest of the runtime that an application gets; empty: none.
std::filesystem::path ActiveRuntime(const Surroundings& surroundings);

// library_path as the loader takes it: below the manifest's folder when relative with a slash, verbatim otherwise.
std::string ResolveLibrary(const std::filesystem::path& manifest, const std::string& library_path);

}  // namespace omni::tools
