// Reimplements the OpenXR loader's search for layers and runtimes: same folders, same order, same rules.
// [OpenXR loader design, "Desktop Layer Discovery"; verified with Debian's loader 1.0.20]
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

struct LayerManifest {
  std::filesystem::path file;
  bool implicit = false;
  std::string problem;  // why the loader skips it; the other fields may then be incomplete
  std::string name;
  std::string library;  // as the loader opens it: absolute, or a bare name that dlopen searches
  std::string negotiate = "xrNegotiateLoaderApiLayerInterface";
  std::string disable_environment;
  std::string enable_environment;
  std::string version;                  // implementation_version
  std::vector<std::string> extensions;  // names in instance_extensions
};

// Folders in search order, existing or not.
std::vector<std::filesystem::path> LayerFolders(const Surroundings& surroundings, bool implicit);

// Every *.json of those folders: implicit layers first.
std::vector<LayerManifest> FindLayerManifests(const Surroundings& surroundings);

LayerManifest ReadLayerManifest(const std::filesystem::path& file, bool implicit);

// OpenXR loaders of 32-bit applications. They read the same manifests, cannot load our library, and give up
// (XR_ERROR_FILE_ACCESS_ERROR; seen with 1.0.20 and 1.1.47).
std::vector<std::filesystem::path> LoadersOf32Bit(const Surroundings& surroundings);

// Recognised by the layer's name, or a broken manifest by its file name.
bool IsOurs(const LayerManifest& manifest);

// The names in XR_ENABLE_API_LAYERS, in order.
std::vector<std::string> EnabledByVariable(const Surroundings& surroundings);

// Whether the loader finds a layer named in XR_ENABLE_API_LAYERS. Debian's loader 1.0.20 searches implicit layers only
// if there is an explicit one too.
bool FoundByName(const std::vector<LayerManifest>& manifests, const std::string& name,
                 const Surroundings& surroundings);

// The library exists, as far as can be checked without opening it: a bare name is resolved by dlopen.
bool LibraryIsThere(const LayerManifest& manifest);

// The loader would use it: valid, its library exists, and if implicit it is enabled.
bool IsUsable(const LayerManifest& manifest, const Surroundings& surroundings);

// The manifest of the runtime that an application gets; empty: none.
std::filesystem::path ActiveRuntime(const Surroundings& surroundings);

// library_path as the loader resolves it: below the manifest's folder when relative with a slash, verbatim otherwise.
std::string ResolveLibrary(const std::filesystem::path& manifest, const std::string& library_path);

// Asks the OpenXR loader of this machine which layers it finds.

// Opens libopenxr_loader.so.1, as an application would, with the environment of this process; no runtime is started.
LoaderAnswer QueryLoader();

}  // namespace omni::tools
