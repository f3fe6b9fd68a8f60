// manifests/device/twin.toml -> TruthParameters of the simulated base. Errors as in device_file.h.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/base/truth_parameters.h"

namespace omni::config {

base::Result<base::TruthParameters> LoadTwinFile(const std::string& path);

// `name` stands for the file in messages.
base::Result<base::TruthParameters> ParseTwin(const std::string& text, const std::string& name);

// The parameters built into the binary: the same numbers as manifests/device/twin.toml.
const base::TruthParameters& DefaultTwin();

}  // namespace omni::config
