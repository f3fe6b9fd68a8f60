// XrTime and CLOCK_MONOTONIC.
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "layer/src/instance/clock.h"
#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_clock {

constexpr std::int64_t kMs_ns = 1'000'000;

// A runtime that shows frames 1.5 periods after xrWaitFrame returned, with a clock of its own.
struct Frames {
  std::int64_t period_ns = 11'111'111;
  double drift = 0;                        // of its clock against ours
  std::int64_t offset_ns = 5'000'000'000;  // at our 0
  std::mt19937 random{7};

  std::int64_t OffsetAt(std::int64_t now_ns) const {
    return offset_ns + static_cast<std::int64_t>(drift * static_cast<double>(now_ns));
  }
  // Frame `n`; `late_ns` between the frame's start and the return of xrWaitFrame, `later` periods of extra pipeline.
  XrFrameState At(std::int64_t start_ns, int later = 0) const {
    XrFrameState state{XR_TYPE_FRAME_STATE};
    state.predictedDisplayPeriod = period_ns;
    state.predictedDisplayTime = start_ns + OffsetAt(start_ns) + period_ns * 3 / 2 + later * period_ns;
    return state;
  }
};

// The fall-back follows a clock that drifts, despite outliers: late returns, frames planned further ahead.
TEST(FallbackClock, TracksDriftingClockDespiteOutliers) {
  for (const double drift : {-200e-6, 0.0, 200e-6}) {
    Frames frames;
    frames.drift = drift;
    layer::FrameClock clock;
    std::uniform_real_distribution<> uniform(0, 1);
    for (int n = 0; n < 3000; ++n) {
      const std::int64_t start = 1'000 * kMs_ns + n * frames.period_ns;
      const bool late = uniform(frames.random) < 0.1, planned_later = uniform(frames.random) < 0.1;
      const auto delay_ns = static_cast<std::int64_t>((late ? 8e6 : 2e5) * uniform(frames.random));
      const std::int64_t offset = clock.Add(frames.At(start, planned_later ? 1 : 0), start + delay_ns);
      if (n < 31) continue;
      ASSERT_LT(std::abs(offset - frames.OffsetAt(start)), kMs_ns) << "frame " << n << ", drift " << drift;
    }
  }
}

// A clock that jumps (the machine slept) is followed within half a window.
TEST(FallbackClock, FollowsClockJumpWithinHalfAWindow) {
  Frames frames;
  layer::FrameClock clock;
  std::int64_t start = 0, offset = 0;
  for (int n = 0; n < 100; ++n, start += frames.period_ns) offset = clock.Add(frames.At(start), start);
  EXPECT_EQ(offset, frames.offset_ns);
  frames.offset_ns += 3'600'000 * kMs_ns;
  for (int n = 0; n < 17; ++n, start += frames.period_ns) offset = clock.Add(frames.At(start), start);
  EXPECT_EQ(offset, frames.offset_ns);
}

// CLOCK_MONOTONIC itself: an assumed display delay must not shift the pen.
TEST(FallbackClock, OffsetIsZeroForSameClock) {
  Frames frames;
  frames.offset_ns = 0;
  layer::FrameClock clock;
  for (int later = -1; later < 3; ++later)
    for (std::int64_t n = 0; n < 40; ++n)
      ASSERT_EQ(clock.Add(frames.At(n * frames.period_ns, later), n * frames.period_ns + 100'000), 0) << later;
}

// Whatever times a runtime reports, nothing overflows.
TEST(FallbackClock, ExtremeTimesDoNotOverflow) {
  layer::RuntimeClock clock(XR_NULL_HANDLE, nullptr);
  XrFrameState state{XR_TYPE_FRAME_STATE};
  for (const std::int64_t time : {INT64_MIN, std::int64_t{0}, INT64_MAX}) {
    state.predictedDisplayTime = time;
    state.predictedDisplayPeriod = time;
    for (int n = 0; n < 40; ++n) clock.OnFrame(state, Now_ns());
    for (const XrTime asked : {INT64_MIN, XrTime{0}, INT64_MAX})
      EXPECT_LE(std::abs(clock.ToMonotonic(asked) / 4), std::int64_t{1} << 61);
  }
}

// Over the runtime, whose clock is 1000 s from ours: the pen is located although the application did not enable the
// conversion.
TEST_F(SpacesTest, TimespecExtensionIsUsedButHidden) {
  AppOptions options;
  options.timespec_extension = false;
  App app(options);
  Start(app);
  PFN_xrVoidFunction found = nullptr;
  EXPECT_NE(xrGetInstanceProcAddr(app.instance, "xrConvertTimespecTimeToTimeKHR", &found), XR_SUCCESS);
  service.Fill();
  EXPECT_EQ(Locate(pen, local, Now_ns() - 10 * kMs_ns).location.locationFlags, kSeen);
}

// A runtime that cannot convert times: its frames give the clock, to within a period.
TEST_F(SpacesTest, FrameTimesReplaceMissingTimespecExtension) {
  ASSERT_EQ(omni_test_offer_timespec(0), 0);
  AppOptions options;
  options.timespec_extension = false;
  App app(options);
  for (int frame = 0; frame < 12; ++frame) {
    XrFrameState state{XR_TYPE_FRAME_STATE};
    ASSERT_EQ(xrWaitFrame(app.session, nullptr, &state), XR_SUCCESS);
    ASSERT_GE(xrBeginFrame(app.session, nullptr), XR_SUCCESS);
    const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO,           nullptr, state.predictedDisplayTime,
                             XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0,       nullptr};
    ASSERT_EQ(xrEndFrame(app.session, &end), XR_SUCCESS);
  }
  Start(app);
  service.Fill();
  const std::int64_t t = Now_ns() - 40 * kMs_ns;
  const Seen seen = Locate(pen, local, t);
  ASSERT_EQ(seen.location.locationFlags, kSeen);
  const layer::Motion truth = InLocal(Lissajous(1e-9 * static_cast<double>(t)));
  EXPECT_LT(glm::length(seen.p() - truth.X.p), 0.36 * 0.012) << "a period at the path's greatest speed";
}

}  // namespace test_spaces_clock
}  // namespace omni::test
