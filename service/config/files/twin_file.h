// manifests/device/twin.toml -> TruthParameters of the simulated base. Errors as in device_file.h. A file that says
// `based_on = "ideal"` or "room" has only what is different.
#pragma once

#include <cstdint>
#include <string>

#include "service/base/result.h"
#include "service/base/truth_parameters.h"

namespace omni::config {

base::Result<base::TruthParameters> LoadTwinFile(const std::string& path);

// `name` stands for the file in messages.
base::Result<base::TruthParameters> ParseTwin(const std::string& text, const std::string& name);

// "ideal", "room", or a file; empty: the default. A name wins over a file of that name: write ./room for that one.
base::Result<base::TruthParameters> FindTwin(const std::string& name_or_file);
inline constexpr const char* kTwinHelp =
    "simulated base and room: room (the default), ideal, or a file like those in share/omni/device";
inline constexpr const char* kIdeal = "ideal";
inline constexpr const char* kIdealHelp = "short for --twin ideal: a well calibrated base with nothing nearby";

// The calibration of the default twin's base that Omni ships (manifests/device/twin_calibration.toml): of seed 1, in
// the room. Empty: of another twin, or it is not installed.
inline constexpr std::uint64_t kShippedSeed = 1;
std::string ShippedCalibration(const std::string& twin, std::uint64_t seed);

// All the text that FindTwin's result depends on, as a key for what is computed from it and stored.
base::Result<std::string> TextOfTwin(const std::string& name_or_file);

// Built into the binary, the numbers of manifests/device/twin.toml: a well calibrated base with nothing near.
const base::TruthParameters& IdealTwin();
// manifests/device/room.toml: a base with manufacturing tolerances, in an ordinary room. It needs a calibration.
const base::TruthParameters& RoomTwin();
// The default is the room: a tracker that only works in an ideal room is of no use on a desk.
inline const base::TruthParameters& DefaultTwin() { return RoomTwin(); }

}  // namespace omni::config
