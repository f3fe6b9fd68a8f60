// What happens to bases in `omni-bench room` and `omni-bench stress`: a table of conditions.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/base/truth_parameters.h"
#include "service/loop/tick_config.h"
#include "service/sim/fields/random.h"

namespace omni::bench {

constexpr double kRoomRun_s = 60;

// Events at a base after its calibration; `draw` belongs to the rig.
using Happening = std::function<void(base::TruthParameters&, sim::Random& draw)>;

struct RoomCondition {
  std::string name;
  bool ideal = false;                                 // no room
  std::function<void(base::TruthParameters&)> known;  // already in the room while the base is calibrated
  Happening later;
  std::vector<double> events_s = {};  // from which it has to recover
  bool as_drawn = false;              // never calibrated
  double settle_s = 0;                // of a run that is not judged by `tracked_fraction`; all of it is for `silent`
};

std::vector<RoomCondition> RoomConditions();

// The nominal base with its sensors in the fast, low-power setting.
base::DeviceGeometry FastDevice();

// Name of the room in which a base is calibrated, or "none" for an uncalibrated base; conditions of one name share the
// calibration.
base::TruthParameters RoomOf(const RoomCondition& condition);
std::string SurroundingsOf(const RoomCondition& condition);

// Configuration of omnid after `omni calibrate` there, through a calibration file; or nominal. Error: calibration was
// refused.
base::Result<loop::TickConfig> ConfigIn(const RoomCondition& condition, const base::DeviceGeometry& device,
                                        std::uint64_t seed);

// Calls use(rig, seed, config) for so many bases at once, each calibrated there; seeds from `first_seed` on. Returns
// the first refusal, if there was one: that base was not used.
std::optional<base::Error> OnRigs(const RoomCondition& condition, const base::DeviceGeometry& device, std::size_t rigs,
                                  std::uint64_t first_seed,
                                  const std::function<void(std::size_t, std::uint64_t, const loop::TickConfig&)>& use);

}  // namespace omni::bench
