// inputs.toml in the user's folder: the keyboards and foot pedals that omnid may read (none without it), and the
// mapping of applications that have none of their own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/config/files/app_file.h"
#include "service/config/inputs/input_table.h"

namespace omni::config {

inline constexpr std::size_t kMaxKeyDevices = 8;  // rules in the file

// One or several devices: those at `path`, or all whose name matches `name_glob`.
struct KeyDeviceRule {
  std::string path;       // absolute; empty: by name
  std::string name_glob;  // fnmatch pattern on the device's own name
  bool grab = false;      // true: no other program gets its keys while omnid reads it
};

struct InputSettings {
  std::string hand = "auto";  // "left", "right": that holds the pen, of applications whose file names none
  std::vector<KeyDeviceRule> devices;
  std::optional<InputTable> inputs;
};

base::Result<InputSettings> ParseInputSettings(const std::string& text, const std::string& file);

// All input settings of omnid.
struct InputPlan {
  std::string hand = "auto";  // as InputSettings::hand
  std::vector<KeyDeviceRule> devices;
  InputTable fallback;               // of applications without their own; keys as below
  std::vector<std::uint16_t> slots;  // evdev code of key source i, for all mappings
  std::string file;                  // the user's, if it is there
};

// Reads `file` (empty or missing: no devices, no problem) and assigns common slots to the keys of all of `apps`. Errors
// go to apps.problems: an invalid file counts as missing, an application whose keys do not fit uses the fallback's
// mapping.
InputPlan PlanInputs(const std::string& file, AppTable& apps);

}  // namespace omni::config
