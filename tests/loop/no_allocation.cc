// The tick never allocates: no heap call in idle, contact, friction, scene swap, tracking loss and cold start.
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_loop_no_allocation {

TEST(Quiet, AllocProbeCountsEveryKindOfHeapCall) {
  const loop::AllocProbe probe;
  std::uint64_t seen = 0;
  const auto grew = [&] {
    const bool more = probe.count() > seen;
    seen = probe.count();
    return more;
  };
  void* volatile block = malloc(10);
  EXPECT_TRUE(grew());
  free(block);
  EXPECT_TRUE(grew());
  block = calloc(3, 5);
  EXPECT_TRUE(grew());
  free(block);
  grew();
  block = aligned_alloc(64, 128);
  EXPECT_TRUE(grew());
  free(block);
  EXPECT_TRUE(grew());
  void* aligned = nullptr;
  ASSERT_EQ(posix_memalign(&aligned, 64, 128), 0);
  EXPECT_TRUE(grew());
  free(aligned);
  grew();
  auto owned = std::make_unique<std::vector<int>>(100);
  EXPECT_TRUE(grew());
}

TEST(Quiet, TickNeverAllocates) {
  const haptics::Scene table = TableScene(kTableTop_m);
  const haptics::Scene other = TableScene(kTableTop_m - 0.001);
  sim::HandScript script = PressAndSlide();
  script.waypoints.push_back({.duration_s = 0.3, .tip_base_m = {0, 0, 0.07}, .present = false});
  script.waypoints.push_back({.duration_s = 0.3, .tip_base_m = {0, 0, 0.07}});
  Scenario scenario(script, 4.6);
  std::set<std::string> situations;
  const haptics::Scene* scene = &table;
  while (scenario.twin->Read(scenario.scan, 0) == device::ReadStatus::kScan) {
    loop::Commands commands = Scenario::Open(scenario.scan);
    if (scenario.state.tick < 50) commands.gate = loop::ForceGate::kClosed;
    commands.scene_generation = scenario.state.tick < 1800 ? 1 : 2;
    if (scenario.state.tick > 2500) commands.haptic = {.id = 1, .active = true, .duration_s = 0.1, .amplitude = 0.5};
    const bool first = scenario.state.tick == 0;
    const loop::AllocProbe probe;
    if (first) loop::EnterScene(*scene, 1, scenario.state);
    loop::Tick(scenario.config, scenario.scan, commands, *scene, scenario.state, scenario.output);
    if (scenario.output.wants_scene) {
      scene = &other;
      loop::EnterScene(*scene, 2, scenario.state);
    }
    ASSERT_EQ(probe.count(), 0U) << "tick " << scenario.state.tick;
    scenario.twin->Write(scenario.output.currents);

    const auto& tool = scenario.output.tool;
    if (first) situations.insert("cold start");
    if (scenario.state.gate == 0) situations.insert("idle");
    if (scenario.output.haptics.in_contact) situations.insert("contact");
    if (scenario.output.haptics.contact_count > 0 && scenario.output.haptics.contacts[0].tangential_force_N > 0.02) {
      situations.insert("friction");
    }
    if (scenario.output.wants_scene) situations.insert("scene swap");
    if (tool.status == base::TrackingStatus::kAbsent && tool.ever_tracked) situations.insert("tracking loss");
    if (scenario.state.vibration.playing) situations.insert("vibration");
  }
  EXPECT_EQ(situations, (std::set<std::string>{"cold start", "idle", "contact", "friction", "scene swap",
                                               "tracking loss", "vibration"}));
}

}  // namespace test_loop_no_allocation
}  // namespace omni::test
