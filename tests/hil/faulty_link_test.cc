// A cable that damages frames: every fault, alone and at its rate.
#include <gtest/gtest.h>

#include "tests/hil/faulty_link.h"

namespace omni::hil {
namespace {

std::vector<Frame> Pass(FaultyLink& link, const std::vector<Frame>& frames) {
  std::vector<Frame> out;
  for (const Frame& frame : frames) {
    link.Pass(frame, [&](Frame passed) { out.push_back(std::move(passed)); });
  }
  return out;
}

std::vector<Frame> Numbered(std::size_t count) {
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < count; ++i) frames.push_back(Frame(16, static_cast<std::uint8_t>(i)));
  return frames;
}

TEST(FaultyLink, PassesFramesUnchangedByDefault) {
  FaultyLink link(1);
  const std::vector<Frame> frames = Numbered(100);
  EXPECT_EQ(Pass(link, frames), frames);
}

TEST(FaultyLink, EachFaultAltersFramesAsNamed) {
  const std::vector<Frame> frames = Numbered(2);
  const auto with = [&frames](const LinkFaults& faults) {
    FaultyLink link(1);
    link.SetFaults(faults);
    return Pass(link, frames);
  };
  EXPECT_TRUE(with({.drop = 1}).empty());
  EXPECT_EQ(with({.duplicate = 1}).size(), 4U);
  EXPECT_EQ(with({.reorder = 1}), (std::vector<Frame>{frames[1], frames[0]}));
  for (const Frame& frame : with({.truncate = 1})) EXPECT_LT(frame.size(), 16U);
  const std::vector<Frame> corrupted = with({.corrupt = 1});
  ASSERT_EQ(corrupted.size(), 2U);
  EXPECT_NE(corrupted[0], frames[0]);
  EXPECT_EQ(corrupted[0].size(), 16U);
}

TEST(FaultyLink, FaultsOccurAtTheConfiguredRate) {
  FaultyLink link(7);
  link.SetFaults({.drop = 0.1, .corrupt = 0.2});
  Pass(link, std::vector<Frame>(10000, Frame(16, 0)));
  EXPECT_NEAR(static_cast<double>(link.counts().dropped), 1000, 100);
  EXPECT_NEAR(static_cast<double>(link.counts().corrupted), 1800, 130);
  EXPECT_EQ(link.counts().frames, 10000U);
}

}  // namespace
}  // namespace omni::hil
