// How long answers take, from the base's own stamps.
#include <gtest/gtest.h>

#include <random>

#include "service/device/commands.h"

namespace omni::device {
namespace test_device_response {

wire::Telemetry Acknowledges(std::uint16_t seq, std::uint64_t at_us) {
  wire::Telemetry telemetry;
  telemetry.ack_seq = seq;
  telemetry.ack_rx_device_us = static_cast<std::uint32_t>(at_us);
  return telemetry;
}

TEST(ResponseTime, ConvergesNearThe99thPercentileOfDelays) {
  for (const std::uint64_t start_us : {std::uint64_t{5}, std::uint64_t{0xFFFFFFF0}}) {  // the stamps wrap
    ResponseTime response;
    std::mt19937 random(3);
    std::uniform_int_distribution<std::uint64_t> delay_us(1000, 1500);
    int later = 0;
    for (std::uint64_t i = 0; i < 40'000; ++i) {
      const std::uint64_t t_us = start_us + 1000 * i, took_us = delay_us(random);
      response.OnSent(static_cast<std::uint16_t>(i), t_us);
      response.OnTelemetry(Acknowledges(static_cast<std::uint16_t>(i), t_us + took_us));
      if (i > 20'000 && 1000 * static_cast<std::int64_t>(took_us) > response.late_ns()) ++later;
    }
    EXPECT_GT(response.late_ns(), 1'300'000);
    EXPECT_LT(response.late_ns(), 1'500'000);
    EXPECT_LT(later, 2000);
    EXPECT_GT(later, 100);
  }
}

TEST(ResponseTime, UsesEachAnswerOnceAndIgnoresUnrelatedOnes) {
  ResponseTime response;
  EXPECT_EQ(response.late_ns(), 0);
  response.OnTelemetry(Acknowledges(0, 5000));
  EXPECT_EQ(response.late_ns(), 0) << "nothing was sent";
  response.OnSent(7, 1000);
  response.OnTelemetry(Acknowledges(7, 2250));
  EXPECT_EQ(response.late_ns(), 1'250'000);
  for (int i = 0; i < 100; ++i) response.OnTelemetry(Acknowledges(7, 9000));
  EXPECT_EQ(response.late_ns(), 1'250'000) << "repeated";
  response.OnSent(8, 3000);
  response.OnTelemetry(Acknowledges(8, 2000));
  EXPECT_EQ(response.late_ns(), 1'250'000) << "before the scan: no answer";
  response.OnSent(9, 3000);
  response.OnTelemetry(Acknowledges(9 + 64, 4000));
  EXPECT_EQ(response.late_ns(), 1'250'000) << "another command";
}

}  // namespace test_device_response
}  // namespace omni::device
