// Where Omni's own files, scenes and the user's settings lie.
#pragma once

#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::config {

// The folder of this program, without links: omni, omnid and what they start stand side by side. Empty: unknown.
std::string ProgramFolder();

// ProgramFolder()/../share, of a build tree or of a prefix, wherever that has been moved to. Empty: unknown.
std::string ShareFolder();

// $OMNI_DATA_DIR, else ShareFolder()/omni if it exists, else /usr/share/omni.
std::string DataFolder();

// DataFolder()/scenes: what relative scene names in apps.d are relative to.
std::string ScenesFolder();

// The user's folder of application files: $XDG_CONFIG_HOME/omni/apps.d, else ~/.config/omni/apps.d; empty: no home.
std::string UserAppFolder();

// The user's calibration: $XDG_CONFIG_HOME/omni/calibration.toml, else below ~/.config; empty: no home.
std::string UserCalibrationFile();

// Where bases stand in headsets' spaces: $XDG_CONFIG_HOME/omni/alignments.toml, else below ~/.config; empty: no home.
std::string UserAlignmentFile();

// What the base follows: $XDG_CONFIG_HOME/omni/follow.toml, else below ~/.config; empty: no home.
std::string UserFollowFile();

// The magnets of pens that omnid has learnt: $XDG_CONFIG_HOME/omni/magnets.toml, else below ~/.config; empty: no home.
std::string UserMagnetsFile();

// The user's inputs: $XDG_CONFIG_HOME/omni/inputs.toml, else below ~/.config; empty: no home.
std::string UserInputsFile();

// The latch of an emergency stop: $XDG_STATE_HOME/omni/emergency_stop.toml, else below ~/.local/state; empty: no home.
// Not in $XDG_RUNTIME_DIR, which a logout empties.
std::string UserStopFile();

// Journals of sculpted strokes: $XDG_STATE_HOME/omni/sculpt, else below ~/.local/state; empty: no home.
std::string UserSculptFolder();

// What can be computed again: $XDG_CACHE_HOME/omni, else ~/.cache/omni; empty: no home.
std::string CacheFolder();

// Folders of application files in order of precedence: the user's, then ours.
std::vector<std::string> AppFolders();

// The file of a scene by its name, for commands, application files and scene_render: the first existing file of `name`,
// `name`.glb and `name`.gltf, as a path, then in `scenes_folder` (config::ScenesFolder()). "dragon" and "dragon.glb"
// are both the shipped dragon. The error names the folders that were searched, and the nearest name in them.
base::Result<std::string> FindScene(const std::string& name, const std::string& scenes_folder);

}  // namespace omni::config
