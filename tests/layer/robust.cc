// Careless applications: many threads, a million events, no polls, no syncs, forks.
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "layer/src/instance/event_queue.h"
#include "service/base/sanitized.h"
#include "tests/layer/mini_loader/chain_app.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_robust {

class Robust : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
};

// What one thread of an application may call while others do the same.
void CallEverything(const ChainApp& app, XrSpace pen, XrSpace local, std::uint32_t turn) {
  const Functions& f = app.f;
  const XrTime time = Now_ns() + kRuntimeOffset_ns;
  switch (turn % 10) {
    case 0:
      app.Locate(pen, local, time);
      break;
    case 1: {
      const XrSpace mine = app.ActionSpace(turn % 20 == 1 ? app.right : app.left);
      app.Locate(mine, pen, time - 10'000'000);
      f.DestroySpace(mine);
      break;
    }
    case 2:
      app.Force(app.right);
      break;
    case 3:
      app.Profile(app.right);
      break;
    case 4: {
      const XrBoundSourcesForActionEnumerateInfo info{XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, nullptr,
                                                      app.force};
      XrPath sources[4] = {};
      std::uint32_t count = 0;
      f.EnumerateBoundSourcesForAction(app.session, &info, 4, &count, sources);
      const XrInputSourceLocalizedNameGetInfo name{XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO, nullptr, sources[0],
                                                   7};
      char text[100];
      f.GetInputSourceLocalizedName(app.session, &name, 100, &count, text);
      break;
    }
    case 5: {
      const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, app.right};
      const XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION, nullptr, XR_MIN_HAPTIC_DURATION, 0, 0.5f};
      f.ApplyHapticFeedback(app.session, &info,
                            static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&vibration)));
      f.StopHapticFeedback(app.session, &info);
      break;
    }
    case 6:
      app.Locate(local, pen, time + 5'000'000);
      break;
    case 7: {
      XrActionSetCreateInfo info{XR_TYPE_ACTION_SET_CREATE_INFO, nullptr, "", "", turn % 3};
      std::snprintf(info.actionSetName, sizeof(info.actionSetName), "set%u", turn);
      std::snprintf(info.localizedActionSetName, sizeof(info.localizedActionSetName), "Set %u", turn);
      XrActionSet set = XR_NULL_HANDLE;
      if (XR_SUCCEEDED(f.CreateActionSet(app.instance, &info, &set))) f.DestroyActionSet(set);
      break;
    }
    case 8:
      app.Sync();
      break;
    default: {
      XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
      f.PollEvent(app.instance, &event);
    }
  }
}

// [fundamentals-threading-behavior] every function from every thread, while the pen comes and goes and a second
// application is created and destroyed. Under ThreadSanitizer: no data race.
TEST_F(Robust, ConcurrentCallsFromManyThreadsSucceed) {
  const MiniLoader loader({OmniLayer()});
  FakeService service;
  ChainApp app(loader);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrSpace pen = app.ActionSpace(app.right);
  const XrSpace local = app.Local();
  std::atomic<bool> stop{false};
  std::atomic<std::uint32_t> turn{0};
  std::atomic<int> failed{0};
  std::vector<std::thread> threads;
  threads.reserve(6);
  for (int i = 0; i < 5; ++i) {
    threads.emplace_back([&] {
      try {
        while (!stop) CallEverything(app, pen, local, turn.fetch_add(1));
      } catch (const std::exception&) {
        ++failed;
      }
    });
  }
  threads.emplace_back([&] {
    ChainOptions idle;
    idle.begin = false;
    try {
      while (!stop) const ChainApp other(loader, idle);
    } catch (const std::exception&) {
      ++failed;
    }
  });
  const char* asked = std::getenv("OMNI_FUZZ");  // scripts/fuzz-layer: for longer
  const int rounds = asked ? 5 * std::atoi(asked) : 100;
  for (int i = 0; i < rounds; ++i) {
    service.SetFlags(i % 10 == 9 ? 0 : protocol::kToolPoseValid | protocol::kToolTracked);
    service.Set(protocol::InputIndex::kTipForce, 0.01f * static_cast<float>(i % 100));
    service.Fill();
    Pause_ms(3);
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failed, 0) << "a valid call failed";
  EXPECT_GT(turn, 500u);
  RecordProperty("calls", static_cast<int>(turn));
}

// [xrPollEvent] an application that does not poll: the queues are bounded, and the loss is reported.
TEST_F(Robust, UnpolledEventsAreBoundedAndLossIsReported) {
  const int events = base::kSanitized ? 100'000 : 1'000'000;
  const MiniLoader loader({OmniLayer()});
  FakeService service;
  ChainApp app(loader);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  app.Poll();
  app.events.clear();
  const std::size_t heap = mallinfo2().uordblks;
  for (int i = 0; i < events; ++i) omni_test_set_focus(i % 2);
  // Those of the layer: the profile of our hand comes and goes.
  for (int i = 0; i < 1000; ++i) {
    service.SetFlags(i % 2 == 0 ? 0 : protocol::kToolPoseValid | protocol::kToolTracked);
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
  }
  if (!base::kSanitized) {
    EXPECT_LT(mallinfo2().uordblks, heap + std::size_t{4} * 1024 * 1024);
  }
  app.Poll();
  EXPECT_LT(app.events.size(), 1000u);
  const auto count = [&](XrStructureType type) { return std::count(app.events.begin(), app.events.end(), type); };
  EXPECT_EQ(count(XR_TYPE_EVENT_DATA_EVENTS_LOST), 1);
  EXPECT_LE(count(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 2) << "one event is enough";
}

// The same for the queue of the layer's own events.
TEST_F(Robust, LayerEventQueueIsBounded) {
  layer::EventQueue queue;
  const XrEventDataInteractionProfileChanged event{XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, nullptr,
                                                   XR_NULL_HANDLE};
  constexpr std::uint32_t kEvents = 1'000'000;
  for (std::uint32_t i = 0; i < kEvents; ++i) queue.Push(event);
  XrEventDataBuffer out{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
  ASSERT_TRUE(queue.Pop(out));
  ASSERT_EQ(out.type, XR_TYPE_EVENT_DATA_EVENTS_LOST);
  XrEventDataEventsLost lost;
  std::memcpy(&lost, &out, sizeof(lost));
  EXPECT_EQ(lost.lostEventCount, kEvents - layer::EventQueue::kMostWaiting);
  std::size_t waiting = 0;
  while (queue.Pop(out)) ++waiting;
  EXPECT_EQ(waiting, layer::EventQueue::kMostWaiting);
}

// The pen stays inactive, nothing breaks, and the first sync activates it.
TEST_F(Robust, PenStaysInactiveUntilFirstSync) {
  const MiniLoader loader({OmniLayer()});
  FakeService service;
  ChainApp app(loader);
  const XrSpace pen = app.ActionSpace(app.right);
  const XrSpace local = app.Local();
  for (int i = 0; i < 200; ++i) {
    service.Set(protocol::InputIndex::kSelect, static_cast<float>(i % 2));
    service.Fill();
    app.Poll();
    ASSERT_EQ(app.Locate(pen, local, Now_ns() + kRuntimeOffset_ns).locationFlags, 0u);
    ASSERT_EQ(app.Profile(app.right), "");
    ASSERT_FLOAT_EQ(app.Force(app.right), 0.0f);
    if (i % 10 == 0) Pause_ms(2);
  }
  EXPECT_TRUE(app.WaitProfile(service, kTouch));
  EXPECT_NE(app.Locate(pen, local, Now_ns() + kRuntimeOffset_ns).locationFlags, 0u);
}

// A child that inherits everything may call and exit as it likes; the parent goes on.
TEST_F(Robust, ForkedChildDoesNotDisturbParent) {
  if (base::kSanitized) GTEST_SKIP() << "a fork of a process with threads is not for sanitizers";
  const MiniLoader loader({OmniLayer()});
  FakeService service;
  ChainApp app(loader);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrSpace pen = app.ActionSpace(app.right);
  const XrSpace local = app.Local();
  for (int i = 0; i < 5; ++i) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      alarm(20);
      const XrSpaceLocation located = app.Locate(pen, local, Now_ns() + kRuntimeOffset_ns);
      app.Force(app.right);
      _exit(located.locationFlags == 0 ? 1 : 0);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "status " << status;
    service.Set(protocol::InputIndex::kTipForce, 0.125f * static_cast<float>(i));
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    EXPECT_FLOAT_EQ(app.Force(app.right), 0.125f * static_cast<float>(i));
  }
  EXPECT_EQ(service.heard().gone, 0) << "the child's end is not the application's";
}

}  // namespace test_robust
}  // namespace omni::test
