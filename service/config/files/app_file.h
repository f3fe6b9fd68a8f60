// manifests/apps.d/*.toml: which scene an OpenXR application gets, what its inputs are, and with what options. One
// file, one entry. User files in $XDG_CONFIG_HOME/omni/apps.d come first and win; files are read in name order; the
// first glob that matches wins.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/config/inputs/input_table.h"

namespace omni::config {

inline constexpr std::string_view kHands[] = {"auto", "left", "right"};  // that holds the pen

inline constexpr std::size_t kMaxAppFiles = 256;  // of one folder; further ones are skipped, with a problem

enum class Up { kY, kZ };  // axis of the file; glTF says y

enum class Placement { kAsAuthored, kFit };  // kFit: scaled and moved into reach of the device

// What can be touched in a file without any haptic tag: nothing, or all of it with the default material.
enum class Touch { kTagged, kAll };

inline constexpr std::size_t kMaxTagBytes = 4096;  // of AppEntry::tags

struct AppEntry {
  std::string file;              // where it came from, for messages
  std::string application_glob;  // fnmatch pattern on XrApplicationInfo::applicationName
  std::string scene;             // absolute path after loading (relative paths are relative to the scenes folder);
                                 // empty: none, the file is about inputs only
  Placement placement = Placement::kAsAuthored;
  Touch touch = Touch::kTagged;
  Up up = Up::kY;
  base::Vec3 offset_base_m;
  double scale = 1;
  double force_scale = 1;  // [0, 1]
  std::string tags;        // haptic tags by names of nodes and materials, as JSON; empty: none
  // Settings for the application's OpenXR layer.
  std::string profile;               // interaction profile path; empty: the layer's order
  std::string hand = "auto";         // "left", "right"; "auto": omnid's, else the layer's default
  double rest_after_s = 0;           // put down after lying still for so long; 0: the layer's default, -1: never
  std::optional<InputTable> inputs;  // empty: the user's own, or the default mapping
};

struct AppTable {
  std::vector<AppEntry> entries;
  std::vector<std::string> problems;  // files that were skipped, and why (the others stay in force)
};

// Folders in order of precedence. Missing folders are fine.
AppTable LoadAppTable(const std::vector<std::string>& folders, const std::string& scenes_folder);

// One file's text; `file` names it in messages.
base::Result<AppEntry> ParseAppFile(const std::string& text, const std::string& file, const std::string& scenes_folder);

// Null: no entry matches.
const AppEntry* FindApp(const AppTable& table, const std::string& application);

}  // namespace omni::config
