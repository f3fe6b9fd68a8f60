// A grating as a hand feels it: the force that the coils of the whole twin deliver, in a room (a simulation).
#include <gtest/gtest.h>

#include "service/loop/realtime.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/loop_replay.h"
#include "tests/support/touch/stroked_plate.h"

namespace omni::test {
namespace {

TEST(GratingFelt, InItsOwnBandAndSilentAtRest) {
  loop::FlushDenormals();
  constexpr std::uint64_t kSeed = 1;
  const auto config = CalibratedTick(kSeed);
  ASSERT_TRUE(config.ok()) << config.error();
  const TempFolder folder;
  const auto stroke = [&](double amplitude_m, double speed_m_s) {
    return StrokePlate(*config, {.amplitude_m = amplitude_m, .wavelength_m = 1e-3}, speed_m_s, kSeed,
                       folder.Path("truth.csv"));
  };
  const auto plain = stroke(0, 0.04), slow = stroke(2e-4, 0.02), quick = stroke(2e-4, 0.04);
  ASSERT_TRUE(plain.ok() && slow.ok() && quick.ok());
  EXPECT_LE(quick->rest_N, 1.1 * plain->rest_N);
  EXPECT_GE(slow->in_band, 0.7);
  EXPECT_GE(quick->in_band, 0.6);
  EXPECT_GE(slow->delivered_N, 0.05);
}

}  // namespace
}  // namespace omni::test
