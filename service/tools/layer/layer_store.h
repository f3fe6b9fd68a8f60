// The layer's implicit manifest: with it in a folder that the OpenXR loader searches, every application gets the layer.
// It is made from the explicit one that the build or the installation left, with the library's absolute path and the
// variable that keeps the layer out of an application.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {

enum class LayerScope { kUser, kSystem };

// $XDG_DATA_HOME/openxr/1/api_layers/implicit.d, else below ~/.local/share; for all users: below /etc, which the loader
// always searches. Error: no home.
base::Result<std::filesystem::path> ImplicitFolder(const Surroundings& surroundings, LayerScope scope);

// The explicit manifest beside this program (build tree or installation), else the first sound one that the loader
// finds. Error, with the remedy: there is none, or its library is missing or not a layer.
base::Result<LayerManifest> FindInstalledLayer(const Surroundings& surroundings);

// DISABLE_<layer>_<implementation version>: it changes with each version, as the loader's rules require.
std::string DisableVariable(const LayerManifest& manifest);

// Text of the implicit manifest for that explicit one. Error: the file cannot be read any more.
base::Result<std::string> ImplicitManifestText(const LayerManifest& explicit_manifest);

struct EnabledLayer {
  std::filesystem::path file;
  bool replaced = false;  // there was one of ours
};
// Writes the manifest atomically. Fails for a folder without write permission, another layer's file, a second manifest
// in another folder and, for a user, under `sudo`, whose files the user could not remove.
base::Result<EnabledLayer> EnableLayer(const Surroundings& surroundings, LayerScope scope);

// Removes every implicit manifest of the layer from that folder; empty: there was none.
base::Result<std::vector<std::filesystem::path>> DisableLayer(const Surroundings& surroundings, LayerScope scope);

}  // namespace omni::tools
