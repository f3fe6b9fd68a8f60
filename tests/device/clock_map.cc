// ClockMap against a simulated base and link: the true mapping is known, and errors are held against it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>

#include "service/device/clock_map.h"

namespace omni::device {
namespace test_device_clock_map {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::int64_t kSecond_ns = 1'000'000'000;

struct Way {
  double least_us = 0;
  double jitter_us = 0;  // mean of the exponential part
};

struct LinkOptions {
  double drift_ppm = 0;  // device clock fast
  Way there{150, 300};
  Way back{400, 1000};
  double lost = 0;  // share of commands that never arrive
  std::uint64_t seed = 1;
  std::uint64_t device_start_us = 0;
};

struct Step {
  double seconds = 0;   // since the begin
  double error_us = 0;  // mapped - true
  double delay_us = 0;  // of this frame: received - true
  std::int64_t mapped_ns = 0;
};

// One base, one host that answers every telemetry. Time is true time; the host's clock has no error.
class Link {
 public:
  explicit Link(const LinkOptions& options) : options_(options), random_(options.seed) {
    device_offset_us_ = static_cast<double>(options.device_start_us);
  }

  // One millisecond: telemetry out, its arrival into the map, a command in answer.
  Step Tick(ClockMap& map) {
    now_ns_ += kMillisecond_ns;
    while (!commands_.empty() && commands_.front().arrival_ns <= now_ns_) {
      ack_ = commands_.front();
      commands_.pop_front();
    }
    const std::int64_t arrival_ns = std::max(now_ns_ + Delay_ns(options_.back) + stall_ns_, last_arrival_ns_ + 1);
    last_arrival_ns_ = arrival_ns;
    ClockReading reading{.t_device_us = Device_us(now_ns_), .received_ns = arrival_ns};
    if (ack_.sent_us != 0) {
      reading.ack_host_us = ack_.sent_us;
      reading.ack_rx_device_us = static_cast<std::uint32_t>(Device_us(ack_.arrival_ns));
    }
    const std::int64_t mapped_ns = map.Add(reading);
    EXPECT_LE(mapped_ns, std::max(arrival_ns, before_ns_ + 1));
    EXPECT_GT(mapped_ns, before_ns_);
    before_ns_ = mapped_ns;
    if (answers_ && Uniform() >= options_.lost) Send(arrival_ns + 60'000);
    return {.seconds = 1e-9 * static_cast<double>(now_ns_ - kBegin_ns),
            .error_us = 1e-3 * static_cast<double>(mapped_ns - now_ns_),
            .delay_us = 1e-3 * static_cast<double>(arrival_ns - now_ns_),
            .mapped_ns = mapped_ns};
  }

  void ResetDevice() {
    device_offset_us_ = -DriftedTime_us(now_ns_);
    commands_.clear();
    ack_ = {};
  }
  void Leap(double by_us) { device_offset_us_ += by_us; }
  void Stall(std::int64_t stall_ns) { stall_ns_ = stall_ns; }
  void Answer(bool answers) { answers_ = answers; }

  double HalfAsymmetry_us() const { return 0.5 * (options_.back.least_us - options_.there.least_us); }

 private:
  static constexpr std::int64_t kBegin_ns = 1000 * kSecond_ns;

  struct Command {
    std::uint64_t sent_us = 0;
    std::int64_t arrival_ns = 0;
  };

  double Uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  std::int64_t Delay_ns(const Way& way) {
    const double jitter_us = way.jitter_us > 0 ? std::exponential_distribution<double>(1 / way.jitter_us)(random_) : 0;
    return std::llround(1e3 * (way.least_us + jitter_us));
  }
  double DriftedTime_us(std::int64_t t_ns) const {
    return 1e-3 * static_cast<double>(t_ns - kBegin_ns) * (1 + 1e-6 * options_.drift_ppm);
  }
  std::uint64_t Device_us(std::int64_t t_ns) const {
    return static_cast<std::uint64_t>(std::max(0.0, std::floor(DriftedTime_us(t_ns) + device_offset_us_)));
  }
  void Send(std::int64_t t_ns) {
    const std::int64_t before_ns = commands_.empty() ? 0 : commands_.back().arrival_ns;
    commands_.push_back({.sent_us = static_cast<std::uint64_t>(t_ns / 1000),
                         .arrival_ns = std::max(t_ns + Delay_ns(options_.there), before_ns)});
  }

  LinkOptions options_;
  std::mt19937_64 random_;
  std::deque<Command> commands_;
  Command ack_;
  double device_offset_us_ = 0;
  std::int64_t now_ns_ = kBegin_ns;
  std::int64_t last_arrival_ns_ = 0;
  std::int64_t before_ns_ = -1;
  std::int64_t stall_ns_ = 0;
  bool answers_ = true;
};

// Largest |error - half the asymmetry of the fastest paths| from `from_s` to `to_s`.
double WorstError_us(Link& link, ClockMap& map, double from_s, double to_s) {
  double worst_us = 0;
  for (Step step; step.seconds < to_s;) {
    step = link.Tick(map);
    if (step.seconds >= from_s) worst_us = std::max(worst_us, std::abs(step.error_us - link.HalfAsymmetry_us()));
  }
  return worst_us;
}

class ClockMapDrift : public testing::TestWithParam<double> {};

// Jitter of 0.3 ms there and 1 ms back (means), every command acknowledged: the figures of clock_map.h.
TEST_P(ClockMapDrift, ErrorFallsBelow25usUnderAsymmetricJitter) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Link link({.drift_ppm = GetParam(), .seed = seed});
    ClockMap map;
    EXPECT_LT(WorstError_us(link, map, 0.3, 3), 150) << "seed " << seed;
    EXPECT_LT(WorstError_us(link, map, 3, 10), 60) << "seed " << seed;
    EXPECT_LT(WorstError_us(link, map, 10, 60), 25) << "seed " << seed;
    EXPECT_NEAR(map.drift_ppm(), -GetParam(), 1) << "seed " << seed;
    EXPECT_NEAR(map.round_trip_us(), 550, 50);
    EXPECT_EQ(map.restarts() + map.refused(), 0U);
  }
}

TEST_P(ClockMapDrift, QueueingErrorStaysWithinAboutHalfTheRoundTrip) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Link link({.drift_ppm = GetParam(), .there = {2000, 500}, .back = {100, 3000}, .seed = seed});
    ClockMap map;
    for (int i = 0; i < 20'000; ++i) {
      const Step step = link.Tick(map);
      ASSERT_LE(step.error_us, step.delay_us + 1) << "never later than its arrival";
      if (!map.acknowledged()) {
        ASSERT_GE(step.error_us, -1) << "by arrival: never too early";
        continue;
      }
      // The line also weighs samples of somewhat longer round trips; 100 ppm of the second for which the first sample
      // holds, and stamps of whole microseconds.
      ASSERT_LE(std::abs(step.error_us), 0.6 * map.round_trip_us() + 102) << "seed " << seed << ", tick " << i;
    }
  }
}

TEST_P(ClockMapDrift, Losing99PercentOfCommandsKeepsErrorBelow150us) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Link link({.drift_ppm = GetParam(), .lost = 0.99, .seed = seed});
    ClockMap map;
    EXPECT_LT(WorstError_us(link, map, 15, 60), 150) << "seed " << seed;
    EXPECT_EQ(map.restarts() + map.refused(), 0U);
  }
}

TEST_P(ClockMapDrift, WithoutAcknowledgementsMapsByFastestArrival) {
  Link link({.drift_ppm = GetParam()});
  link.Answer(false);
  ClockMap map;
  for (int i = 0; i < 60'000; ++i) {
    const Step step = link.Tick(map);
    ASSERT_GE(step.error_us, -1);
    ASSERT_LE(step.error_us, step.delay_us + 1);
    if (i > 100) {
      ASSERT_LT(step.error_us, 400 + 200) << "tick " << i;
    }
  }
  EXPECT_FALSE(map.acknowledged());
}

// Ten minutes without a command: the line is extrapolated.
TEST_P(ClockMapDrift, ExtrapolatesThroughTenMinutesWithoutCommands) {
  Link link({.drift_ppm = GetParam()});
  ClockMap map;
  WorstError_us(link, map, 60, 60);
  link.Answer(false);
  EXPECT_LT(WorstError_us(link, map, 60, 660), 600);
  link.Answer(true);
  WorstError_us(link, map, 660, 700);
  EXPECT_LT(WorstError_us(link, map, 700, 720), 25);
  EXPECT_EQ(map.restarts(), 0U);
}

TEST_P(ClockMapDrift, DeviceResetRestartsMapWithoutTurningTimeBack) {
  Link link({.drift_ppm = GetParam(), .device_start_us = 4'000'000'000});  // the low 32 bits wrap during the test
  ClockMap map;
  EXPECT_LT(WorstError_us(link, map, 10, 320), 25);
  link.ResetDevice();
  const Step first = link.Tick(map);
  EXPECT_FALSE(map.acknowledged());
  EXPECT_NEAR(first.error_us, first.delay_us, 1) << "by arrival again";
  EXPECT_LT(WorstError_us(link, map, 320.3, 323), 150);
  EXPECT_LT(WorstError_us(link, map, 330, 360), 25);
  EXPECT_EQ(map.restarts(), 1U);
}

TEST_P(ClockMapDrift, DetectsClockLeapsInEitherDirection) {
  for (const double leap_us : {-5'000'000.0, -8'000.0, 8'000.0, 5'000'000.0}) {
    Link link({.drift_ppm = GetParam()});
    ClockMap map;
    WorstError_us(link, map, 20, 20);
    link.Leap(leap_us);
    EXPECT_LT(WorstError_us(link, map, 21, 24), 150) << leap_us;
    EXPECT_LT(WorstError_us(link, map, 31, 40), 25) << leap_us;
    EXPECT_GE(map.restarts(), 1U);
    EXPECT_LE(map.restarts(), 2U) << "an acknowledgement that spans the leap may cost another";
  }
}

INSTANTIATE_TEST_SUITE_P(Crystals, ClockMapDrift, testing::Values(-100.0, -50.0, 0.0, 50.0, 100.0));

// The host's process was stopped: frames arrive late, the device's clock is unaffected.
TEST(ClockMap, DelayedFramesDoNotRestartTheMap) {
  Link link({.drift_ppm = 40});
  ClockMap map;
  WorstError_us(link, map, 10, 10);
  link.Stall(2 * kSecond_ns);
  EXPECT_LT(WorstError_us(link, map, 10, 12), 40) << "stamps stay those of the samples";
  link.Stall(0);
  EXPECT_LT(WorstError_us(link, map, 12, 20), 40);
  EXPECT_EQ(map.restarts(), 0U);
}

TEST(ClockMap, FirstReadingMapsToItsArrivalTime) {
  ClockMap map;
  EXPECT_EQ(map.HostTime_ns(5), 0);
  EXPECT_EQ(map.Add({.t_device_us = 7'000, .received_ns = 123'456'789}), 123'456'789);
  EXPECT_EQ(map.HostTime_ns(8'000), 124'456'789);
  EXPECT_EQ(map.Add({.t_device_us = 7'000, .received_ns = 123'456'999}), 123'456'789) << "the same stamp";
  EXPECT_EQ(map.HostTime_ns(~std::uint64_t{0}), 0) << "an impossible instant";
}

TEST(ClockMap, SingleAcknowledgementMapsToTheExactMidpoint) {
  ClockMap map;
  // Out at 1000 us, in at device 50 400 us, telemetry of 50 600 us, back at 2000 us: offset -49 000 us.
  map.Add({.t_device_us = 50'600, .received_ns = 2'000'000, .ack_host_us = 1'000, .ack_rx_device_us = 50'400});
  EXPECT_TRUE(map.acknowledged());
  EXPECT_NEAR(map.round_trip_us(), 800, 1e-6);
  EXPECT_EQ(map.HostTime_ns(50'600), 1'600'000);
}

TEST(ClockMap, CountsAndIgnoresImpossibleReadings) {
  ClockMap map;
  const ClockReading good{.t_device_us = 50'000, .received_ns = 3'000'000'000};
  const std::int64_t before_ns = map.Add(good);
  ClockReading future = good;
  future.ack_host_us = 3'000'001;
  future.ack_rx_device_us = 49'900;
  map.Add(future);
  EXPECT_EQ(map.refused(), 1U);
  ClockReading slow = good;
  slow.ack_host_us = 2'800'000;  // a round trip of 200 ms
  slow.ack_rx_device_us = 49'900;
  map.Add(slow);
  EXPECT_EQ(map.refused(), 2U);
  ClockReading never = good;
  never.t_device_us = ~std::uint64_t{0};
  never.received_ns = 3'000'000'001;
  EXPECT_EQ(map.Add(never), 3'000'000'001);
  EXPECT_EQ(map.refused(), 3U);
  EXPECT_FALSE(map.acknowledged());
  EXPECT_EQ(map.HostTime_ns(50'000), before_ns);
}

// Random contents with a valid CRC: whatever the device sends, mapped times increase and stay near the host's.
TEST(ClockMap, RandomReadingsNeverTurnTimeBack) {
  std::mt19937_64 random(3);
  ClockMap map;
  std::int64_t now_ns = kSecond_ns;
  std::int64_t before_ns = 0;
  for (int i = 0; i < 300'000; ++i) {
    now_ns += static_cast<std::int64_t>(random() % 3'000'000);
    ClockReading reading{.received_ns = now_ns};
    reading.t_device_us = random() >> (random() % 64);
    if (random() % 2 == 0) reading.ack_host_us = static_cast<std::uint64_t>(now_ns / 1000) - random() % 20'000;
    if (random() % 16 == 0) reading.ack_host_us = random();
    reading.ack_rx_device_us = static_cast<std::uint32_t>(reading.t_device_us - random() % 2000);
    const std::int64_t mapped_ns = map.Add(reading);
    ASSERT_GE(mapped_ns, before_ns);
    ASSERT_LE(mapped_ns, std::max(now_ns, before_ns + 1));
    before_ns = mapped_ns;
    map.HostTime_ns(random());
    if (random() % 1000 == 0) map.Restart();
  }
  EXPECT_GT(map.restarts(), 0U);
  EXPECT_GT(map.refused(), 0U);
}

}  // namespace test_device_clock_map
}  // namespace omni::device
