// Random sequences of calls against the bare runtime, without and with the pen, and with garbage in the service's
// memory. OMNI_FUZZ: that many sequences of each kind instead of what ctest has time for, from OMNI_FUZZ_FIRST on
// (scripts/fuzz-layer).
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <set>

#include "tests/layer/fuzz/garbage_service.h"
#include "tests/layer/fuzz/sequence.h"
#include "tests/layer/support/app.h"
#include "tests/layer/support/scene_messages.h"

namespace omni::test {
namespace test_layer_fuzz {

int Sequences(int usual) {
  const char* asked = std::getenv("OMNI_FUZZ");
  return asked ? std::atoi(asked) : usual;
}

// Different for each kind: the n-th sequence of this run.
std::uint64_t SeedOf(std::uint64_t kind, int n) {
  const char* first = std::getenv("OMNI_FUZZ_FIRST");
  return 1'000'000 * kind + static_cast<std::uint64_t>(first ? std::atoi(first) : 0) + static_cast<std::uint64_t>(n);
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
      const float palm[7] = {0.1f, 1.2f, -0.3f, 0, 0, 0, 1};
      const float moving[6] = {0.2f, -0.1f, 0.1f, 0, 1, 0};
      omni_test_set_hand("left", static_cast<int>(random.Below(2)), palm, random.Percent(50) ? moving : nullptr);
      break;
    }
    case 5: {
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

class LayerFuzz : public testing::Test {
 protected:
  void TearDown() override { omni_test_reset(); }  // whatever world the last sequence has left
};

// [loader: API Layer Conventions and Rules] valid or not, every call returns what it returns without the layer.
TEST_F(LayerFuzz, WithoutPenResultsMatchTheRuntime) {
  const MiniLoader bare({});
  const MiniLoader layered({OmniLayer()});
  const int sequences = Sequences(3000);
  std::size_t calls = 0;
  for (int seed = 0; seed < sequences && !testing::Test::HasFailure(); ++seed) {
    omni_test_reset();
    const Sequence alone(bare, Options(SeedOf(0, seed)));
    omni_test_reset();
    const Sequence through(layered, Options(SeedOf(0, seed)));
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

// A service that is up in most steps, moves its pen, loses it, dies and comes back.
class LivingService {
 public:
  void Stir(Random& random) {
    if (random.Percent(1) && random.Percent(10)) service_.reset();
    if (!service_ && random.Percent(5)) Start();
    if (!service_) return;
    if (random.Percent(20))
      service_->Set(static_cast<protocol::InputIndex>(random.Below(protocol::kInputCount)),
                    static_cast<float>(random.Unit()));
    if (random.Percent(3)) {
      static constexpr std::uint32_t kFlags[] = {0, protocol::kToolPoseValid,
                                                 protocol::kToolPoseValid | protocol::kToolTracked};
      service_->SetFlags(kFlags[random.Below(3)]);
    }
    if (random.Percent(3))
      service_->SetForce(random.Percent(80), static_cast<protocol::ForceStanding>(random.Below(3)));
    if (random.Percent(5)) {
      protocol::ContactSnapshot contacts;
      contacts.scene_generation = 9 + random.Below(2);
      contacts.count = random.Below(4);
      for (protocol::ContactSample& contact : contacts.contacts) contact.object = random.Below(6);
      service_->SetContacts(contacts);
    }
    if (random.Percent(50)) service_->Fill();
  }
  void Revive() {
    if (!service_) Start();
    service_->SetFlags(protocol::kToolPoseValid | protocol::kToolTracked);
    service_->Fill();
  }

 private:
  // Rejects a third of the scenes as broken.
  void Start() {
    service_.emplace();
    service_->SetForce(true, protocol::ForceStanding::kYours);
    service_->AnswerScenes([](const protocol::HapticSceneLoad& load) -> std::vector<std::string> {
      if (load.bytes % 3 == 0)
        return {SceneStateMessage(load.number, protocol::HapticSceneStatus::kFailed, 0, "/meshes/0: is broken")};
      SceneTable table = ManyNodes(4, 3);
      table.nodes[0].flags = protocol::kNodeSoft;
      return {SceneTableMessage(load.number, table),
              SceneStateMessage(load.number, protocol::HapticSceneStatus::kReady, 9, "")};
    });
  }
  std::optional<FakeService> service_;
};

// Calls that must succeed at least once, or the sequences prove nothing about them.
const std::set<std::string> kMeant = {
    "locate many", "joints",      "vibrate",     "envelope",         "pcm",          "sample rate",  "create force",
    "push",        "constrain",   "stop force",  "force properties", "force state",  "create scene", "destroy scene",
    "scene state", "scene nodes", "place scene", "move nodes",       "get material", "set material", "contacts"};

void NoteSuccesses(const Sequence& sequence, std::set<std::string>& calls) {
  for (const std::string& line : sequence.transcript()) {
    const std::size_t arrow = line.find(" -> ");
    if (line.compare(arrow, 5, " -> 0") == 0) calls.insert(line.substr(0, arrow));
  }
}

// Syncs until the pen is the application's, as long as that can take with the service up.
template <class KeepAlive>
bool AwaitPen(const std::function<std::string()>& sync_and_profile, KeepAlive keep_alive) {
  const std::int64_t end = Now_ns() + 250'000'000;
  while (Now_ns() < end) {
    keep_alive();
    if (sync_and_profile() == kTouch) return true;
    Pause_ms(1);
  }
  return false;
}

// Invariants of the specification hold, whatever the application and the pen do.
TEST_F(LayerFuzz, RandomCallsWithPenKeepSpecInvariants) {
  const MiniLoader layered({OmniLayer()});
  const int sequences = Sequences(150);
  LivingService service;
  int met = 0;
  std::size_t calls = 0;
  std::set<std::string> successes;
  for (int seed = 0; seed < sequences && !testing::Test::HasFailure(); ++seed) {
    omni_test_reset();
    omni_test_offer_shapes(seed % 2);
    service.Revive();
    SequenceOptions options = Options(SeedOf(1, seed));
    options.steps = 400;
    options.ours = true;
    options.patience_ns = 100'000'000;
    options.world = [&](Random& random) {
      StirRuntime(random);
      service.Stir(random);
    };
    options.arrive = [&](const auto& sync) { met += AwaitPen(sync, [&] { service.Revive(); }) ? 1 : 0; };
    const Sequence sequence(layered, options);
    calls += sequence.transcript().size();
    NoteSuccesses(sequence, successes);
    ExpectClean(sequence);
  }
  for (const std::string& call : kMeant)
    EXPECT_TRUE(sequences < 100 || successes.count(call) == 1) << call << " never succeeded";
  EXPECT_GT(met, sequences / 3) << "the pen takes part in most sequences";
  RecordProperty("sequences", sequences);
  RecordProperty("calls", static_cast<int>(calls));
}

TEST_F(LayerFuzz, SurvivesGarbageInSharedStateMemory) {
  const MiniLoader layered({OmniLayer()});
  const int sequences = Sequences(150);
  GarbageService service;
  int met = 0;
  for (int seed = 0; seed < sequences && !testing::Test::HasFailure(); ++seed) {
    omni_test_reset();
    SequenceOptions options = Options(SeedOf(2, seed));
    options.steps = 400;
    options.ours = true;
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

}  // namespace test_layer_fuzz
}  // namespace omni::test
