// omni-bench texture: a hand strokes gratings on the whole twin in a room.
#include <vector>

#include "service/loop/realtime.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/work_folder.h"
#include "tests/support/rig/loop_replay.h"
#include "tests/support/touch/stroked_plate.h"

namespace omni::bench {

base::Result<BenchRows> BenchTexture(const BenchOptions& options) {
  loop::FlushDenormals();
  const WorkFolder scratch;
  if (scratch.path().empty()) return base::Error{"no folder for the twin's recordings can be made; check $TMPDIR"};
  const auto config = test::CalibratedTick(options.seed);
  if (!config.ok()) return base::Error{config.error()};
  const auto stroke = [&](const test::GratedPlate& plate, double speed_m_s) {
    return test::StrokePlate(*config, plate, speed_m_s, options.seed, scratch.path() / "truth.csv");
  };
  const std::vector<double> frictions = options.quick ? std::vector{0.1} : std::vector{0.0, 0.1, 0.4, 1.0};
  const std::vector<double> wavelengths_m = options.quick ? std::vector{1e-3} : std::vector{0.5e-3, 1e-3, 2e-3, 3e-3};
  BenchRows rows;
  for (const double friction : frictions) {
    const auto plain = stroke({.friction = friction}, 0.04);
    if (!plain.ok()) return base::Error{plain.error()};
    for (const double wavelength_m : wavelengths_m) {
      for (const double speed_m_s : {0.01, 0.02, 0.04, 0.08, 0.16}) {
        if (speed_m_s / wavelength_m < 5 || speed_m_s / wavelength_m > 200) continue;
        const auto felt = stroke({.amplitude_m = 2e-4, .wavelength_m = wavelength_m, .friction = friction}, speed_m_s);
        if (!felt.ok()) return base::Error{felt.error()};
        rows.push_back({{"wavelength_mm", 1e3 * wavelength_m},
                        {"speed_mm_s", 1e3 * speed_m_s},
                        {"friction", friction},
                        {"in_band", felt->in_band},
                        {"correlation", felt->correlation},
                        {"rest_mN", 1e3 * felt->rest_N},
                        {"plain_rest_mN", 1e3 * plain->rest_N},
                        {"delivered_mN", 1e3 * felt->delivered_N}});
      }
    }
  }
  return rows;
}

}  // namespace omni::bench
