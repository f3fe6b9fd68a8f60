// A hand strokes a grated plate on the whole twin, in a room (a simulation). Judged by the force that the coils
// deliver, from the twin's own record of the truth, over the tip's true place.
#pragma once

#include <cstdint>
#include <filesystem>

#include "service/base/result.h"
#include "service/loop/tick_config.h"

namespace omni::test {

struct GratedPlate {
  double amplitude_m = 0, wavelength_m = 1e-3;
  double friction = 0.1;  // dynamic; the static one is a quarter more
};

struct FeltGrating {
  double in_band = 0;      // share of the ripple's power within 15 % of 1 / wavelength
  double correlation = 0;  // of the force there and back, by place
  double rest_N = 0;       // rms at rest, above 4 Hz
  double delivered_N = 0;  // rms of the ripple
};

// Two strokes of 36 mm there and back along x, of this mean speed. `recording`: of the twin, overwritten.
base::Result<FeltGrating> StrokePlate(const loop::TickConfig& config, const GratedPlate& plate, double speed_m_s,
                                      std::uint64_t seed, const std::filesystem::path& recording);

}  // namespace omni::test
