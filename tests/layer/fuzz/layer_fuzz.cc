// Random sequences of calls against the bare runtime, without and with the pen, and with garbage in the service's
// memory. OMNI_FUZZ: so many sequences of each kind instead of what ctest has time for (scripts/fuzz).
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "tests/layer/app.h"
#include "tests/layer/fuzz/garbage_service.h"
#include "tests/layer/fuzz/sequence.h"

namespace omni::test {
namespace {

int Sequences(int usual) {
  const char* asked = std::getenv("OMNI_FUZZ");
  return asked ? std::atoi(asked) : usual;
}

// What a user does meanwhile, from the sequence's own random numbers.
void StirRuntime(Random& random) {
  switch (random.Below(40)) {
    case 0:
      omni_test_set_focus(static_cast<int>(random.Below(2)));
      break;
    case 1:
      omni_test_set_float("/user/hand/left/input/trigger/value", static_cast<float>(random.Unit()));
      break;
    case 2:
      omni_test_set_vector2("/user/hand/left/input/thumbstick", static_cast<float>(random.Unit()), 0.5f);
      break;
    case 3:
      omni_test_set_device(random.Percent(50) ? "left" : "right", static_cast<int>(random.Below(2)), kTouch);
      break;
    case 4: {
      const float pose[7] = {0.1f, 0, 0.2f, 0, 0, 0, 1};
      if (random.Percent(20)) omni_test_recenter(pose, 0);
      break;
    }
    default:
      break;
  }
}

SequenceOptions Options(std::uint64_t seed) {
  SequenceOptions options;
  options.seed = seed;
  options.world = StirRuntime;
  return options;
}

void ExpectClean(const Sequence& sequence) {
  for (const std::string& violation : sequence.violations()) ADD_FAILURE() << violation;
}

// [loader: API Layer Conventions and Rules] right or wrong, every call ends as it does without the layer.
TEST(LayerFuzz, WithoutThePenEveryResultIsTheRuntimes) {
  const MiniLoader bare({});
  const MiniLoader layered({OmniLayer()});
  const int sequences = Sequences(3000);
  std::size_t calls = 0;
  for (int seed = 0; seed < sequences && !testing::Test::HasFailure(); ++seed) {
    omni_test_reset();
    const Sequence alone(bare, Options(static_cast<std::uint64_t>(seed)));
    omni_test_reset();
    const Sequence through(layered, Options(static_cast<std::uint64_t>(seed)));
    const auto& a = alone.transcript();
    const auto& b = through.transcript();
    calls += b.size();
    for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
      ASSERT_EQ(a[i], b[i]) << "seed " << seed << ", call " << i + 1;
    ASSERT_EQ(a.size(), b.size());
    ExpectClean(alone);
    ExpectClean(through);
  }
  RecordProperty("sequences", sequences);
  RecordProperty("calls", static_cast<int>(calls));
}

// A service that lives in most steps, moves its pen, loses it, dies and comes back.
class LivingService {
 public:
  void Stir(Random& random) {
    if (random.Percent(1) && random.Percent(10)) service_.reset();
    if (!service_ && random.Percent(5)) service_.emplace();
    if (!service_) return;
    if (random.Percent(20))
      service_->Set(static_cast<protocol::InputIndex>(random.Below(protocol::kInputCount)),
                    static_cast<float>(random.Unit()));
    if (random.Percent(3)) {
      static constexpr std::uint32_t kFlags[] = {0, protocol::kToolPoseValid,
                                                 protocol::kToolPoseValid | protocol::kToolTracked};
      service_->SetFlags(kFlags[random.Below(3)]);
    }
    if (random.Percent(50)) service_->Fill();
  }
  void Revive() {
    if (!service_) service_.emplace();
    service_->SetFlags(protocol::kToolPoseValid | protocol::kToolTracked);
    service_->Fill();
  }

 private:
  std::optional<FakeService> service_;
};

// Syncs until the pen is the application's, as long as that can take with the service up.
template <class KeepAlive>
bool AwaitPen(const std::function<std::string()>& sync_and_profile, KeepAlive keep_alive) {
  const std::int64_t end = Now_ns() + 1'000'000'000;
  while (Now_ns() < end) {
    keep_alive();
    if (sync_and_profile() == kTouch) return true;
    Pause_ms(1);
  }
  return false;
}

// What the spec never allows does not happen, whatever the application and the pen do.
TEST(LayerFuzz, InvariantsHoldWithThePen) {
  const MiniLoader layered({OmniLayer()});
  const int sequences = Sequences(150);
  LivingService service;
  int met = 0;
  std::size_t calls = 0;
  for (int seed = 0; seed < sequences && !testing::Test::HasFailure(); ++seed) {
    omni_test_reset();
    service.Revive();
    SequenceOptions options = Options(1'000'000 + static_cast<std::uint64_t>(seed));
    options.steps = 400;
    options.world = [&](Random& random) {
      StirRuntime(random);
      service.Stir(random);
    };
    options.arrive = [&](const auto& sync) { met += AwaitPen(sync, [&] { service.Revive(); }) ? 1 : 0; };
    const Sequence sequence(layered, options);
    calls += sequence.transcript().size();
    ExpectClean(sequence);
  }
  EXPECT_GT(met, sequences / 3) << "of most sequences the pen is a part";
  RecordProperty("sequences", sequences);
  RecordProperty("calls", static_cast<int>(calls));
}

TEST(LayerFuzz, GarbageInTheStateMemory) {
  const MiniLoader layered({OmniLayer()});
  const int sequences = Sequences(150);
  GarbageService service;
  int met = 0;
  for (int seed = 0; seed < sequences && !testing::Test::HasFailure(); ++seed) {
    omni_test_reset();
    SequenceOptions options = Options(2'000'000 + static_cast<std::uint64_t>(seed));
    options.steps = 400;
    options.world = [&](Random& random) {
      for (std::uint32_t i = random.Below(4); i > 0; --i) service.Scribble(random);
      if (random.Percent(30)) service.Heal();
    };
    options.arrive = [&](const auto& sync) { met += AwaitPen(sync, [&] { service.Heal(); }) ? 1 : 0; };
    ExpectClean(Sequence(layered, options));
  }
  EXPECT_GT(met, sequences / 3);
  RecordProperty("sequences", sequences);
}

}  // namespace
}  // namespace omni::test
