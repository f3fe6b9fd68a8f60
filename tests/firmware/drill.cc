// The drill reaches the states it is meant to cover, and its checksum is reproducible; other targets compare with it.
#include "tests/support/drill.h"

#include <gtest/gtest.h>

#include "firmware/wire/messages.h"

namespace omni::firmware {
namespace test_firmware_drill {

TEST(FirmwareDrill, ReachesArmedStateAndExpectedFaults) {
  const DrillTally tally = DrillWithTally(100'000);
  EXPECT_GT(tally.armed_steps, 50'000U);
  EXPECT_GE(tally.frames, 25'000U);
  constexpr std::uint32_t kScenario = wire::kFaultHostSilent | wire::kFaultEmergencyStop | wire::kFaultSupplyLow |
                                      wire::kFaultHallStuck | wire::kFaultHallSensor | wire::kFaultOverCurrent |
                                      wire::kFaultDriver;
  EXPECT_EQ(tally.faults_seen & kScenario, kScenario) << std::hex << tally.faults_seen;
}

TEST(FirmwareDrill, ChecksumIsReproducible) {
  const std::uint32_t crc = DrillChecksum(20'000);
  EXPECT_EQ(DrillChecksum(20'000), crc);
  EXPECT_NE(DrillChecksum(20'001), crc);
  RecordProperty("crc", std::to_string(crc));
}

}  // namespace test_firmware_drill
}  // namespace omni::firmware
