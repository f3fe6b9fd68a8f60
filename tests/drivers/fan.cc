// The fan's speed from its edges: steady, slowing down, standing, disturbed, over the wrap of the clock.
#include "firmware/drivers/fan_tach.h"

#include <gtest/gtest.h>

#include <deque>

namespace omni::drivers {
namespace test_drivers_fan {

struct Capture {
  bool NextEdge(std::uint32_t& t_us) noexcept {
    if (edges.empty()) return false;
    t_us = edges.front();
    edges.pop_front();
    return true;
  }
  std::uint32_t Now_us() const noexcept { return now_us; }

  std::uint32_t now_us = 0xFFFFFFFFU - 200'000;  // wraps within the tests
  std::deque<std::uint32_t> edges;
};

struct FanTest : testing::Test {
  // Turns at `rpm` (0: stands) for `time_us`, with an update every millisecond.
  void Turn(double rpm, std::uint32_t time_us) {
    for (std::uint32_t t_us = 0; t_us < time_us; t_us += 1000) {
      capture.now_us += 1000;
      phase += rpm / 60e6 * 2 * 1000;
      for (; phase >= 1; phase -= 1) capture.edges.push_back(capture.now_us);
      tach.Update();
    }
  }

  Capture capture;
  FanTach<Capture> tach{capture};
  double phase = 0;
};

TEST_F(FanTest, MeasuresSpeed) {
  EXPECT_TRUE(tach.standing()) << "until it has turned once";
  EXPECT_EQ(tach.rpm(), 0U);
  for (const double rpm : {600.0, 3000.0, 6000.0}) {
    Turn(rpm, 500'000);
    EXPECT_NEAR(tach.rpm(), rpm, rpm * 0.11) << "edges are a millisecond coarse here";
    EXPECT_FALSE(tach.standing());
  }
}

TEST_F(FanTest, SpeedNeverRisesWhileTheFanStops) {
  Turn(3000, 500'000);
  std::uint32_t before = tach.rpm();
  for (int i = 0; i < 490; ++i) {
    Turn(0, 1000);
    ASSERT_LE(tach.rpm(), before);
    before = tach.rpm();
  }
  EXPECT_LT(tach.rpm(), 70U);
  Turn(0, 20'000);
  EXPECT_TRUE(tach.standing());
  EXPECT_EQ(tach.rpm(), 0U);
}

TEST_F(FanTest, StandingSurvivesClockWraps) {
  Turn(3000, 500'000);
  for (int i = 0; i < 20'000; ++i) {  // 2.8 hours: the clock wraps twice
    capture.now_us += 500'000;
    tach.Update();
    ASSERT_TRUE(tach.standing() || i == 0);
    ASSERT_EQ(tach.rpm() != 0, !tach.standing());
  }
  Turn(3000, 200'000);
  EXPECT_FALSE(tach.standing());
  EXPECT_NEAR(tach.rpm(), 3000, 330);
}

TEST_F(FanTest, IgnoresImplausibleEdges) {
  Turn(3000, 500'000);
  const std::uint32_t rpm = tach.rpm();
  for (int i = 0; i < 5; ++i) capture.edges.push_back(capture.now_us + 20U * static_cast<std::uint32_t>(i));
  tach.Update();
  EXPECT_GE(tach.disturbances(), 4U);
  EXPECT_LE(tach.rpm(), rpm * 2) << "at most one edge was accepted";
  for (int i = 0; i < 1000; ++i) capture.edges.push_back(capture.now_us);
  tach.Update();
  EXPECT_EQ(capture.edges.size(), 1000U - FanTach<Capture>::kEdgesPerUpdate) << "bounded work";
}

}  // namespace test_drivers_fan
}  // namespace omni::drivers
