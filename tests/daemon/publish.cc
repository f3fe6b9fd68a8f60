// What a tick is for clients: each flag is set by its condition, and by nothing else.
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>

#include "service/base/unique_fd.h"
#include "service/client/state_reader.h"
#include "service/daemon/clients/publish.h"
#include "service/protocol/sample_range.h"

namespace omni::daemon {
namespace test_daemon_publish {

// A tick with forces, whose pen is not tracked and touches nothing.
loop::TickOutput Quiet() {
  loop::TickOutput output;
  output.t_ns = 1'000'000;
  output.gate = 1;
  output.tool.status = base::TrackingStatus::kAbsent;
  return output;
}

struct Row {
  std::uint32_t flags;
  std::function<void(loop::TickOutput&)> change;
};

const Row kRows[] = {
    {protocol::kToolPoseValid,
     [](auto& o) { o.tool.ever_tracked = true, o.tool.status = base::TrackingStatus::kLost; }},
    {protocol::kToolTracked, [](auto& o) { o.tool.status = base::TrackingStatus::kTracking; }},
    {protocol::kToolContact, [](auto& o) { o.haptics.in_contact = true; }},
    {protocol::kToolJoystick, [](auto& o) { o.haptics.joystick = true; }},
    {protocol::kToolPushed, [](auto& o) { o.applied.acts = true; }},
    {protocol::kToolForceCut, [](auto& o) { o.saturated = true; }},
    {protocol::kToolWarm, [](auto& o) { o.warm = true; }},
    {protocol::kToolOutOfReach, [](auto& o) { o.out_of_reach = true; }},
    {protocol::kToolDeviceFault, [](auto& o) { o.faults = loop::kFaultDevice; }},
    {protocol::kToolStiffnessLimited, [](auto& o) { o.applied.stiffness_limited = true; }},
    {protocol::kToolHolding, [](auto& o) { o.haptics.holding = true; }},
    {protocol::kToolSoftened | protocol::kToolStiffnessLimited, [](auto& o) { o.haptics.energy_gain = 0.5; }},
    {protocol::kToolWaits, [](auto& o) { o.haptics.waits = true; }},
};

std::uint32_t PublishedFlags(const loop::TickOutput& output, bool aligned = false) {
  auto publisher = ipc::StatePublisher::Create(1);
  EXPECT_TRUE(publisher.ok());
  const auto reader =
      client::StateReader::Map(base::UniqueFd(::dup((*publisher)->fd())), sizeof(protocol::StateMemory));
  EXPECT_TRUE(reader.ok());
  PublishSink sink(**publisher);
  sink.SetAligned(aligned);
  sink.Publish(output, {}, {});
  protocol::ToolSample sample;
  EXPECT_TRUE((*reader)->ReadNewest(sample));
  return sample.flags;
}

TEST(Publish, EachFlagHasItsCondition) {
  std::uint32_t all = PublishedFlags(Quiet(), true);
  EXPECT_EQ(all, protocol::kToolAligned);
  EXPECT_EQ(PublishedFlags(Quiet()), 0U);
  for (const Row& row : kRows) {
    loop::TickOutput output = Quiet();
    row.change(output);
    EXPECT_EQ(PublishedFlags(output), row.flags) << "flag " << row.flags;
    all |= row.flags;
  }
  EXPECT_EQ(all, protocol::kKnownToolFlags) << "a flag without a row here";
}

// A closed gate: nothing is felt.
TEST(Publish, WithoutForceNothingIsTouched) {
  for (const auto& change :
       {+[](loop::TickOutput& o) { o.haptics.in_contact = true; },
        +[](loop::TickOutput& o) { o.haptics.holding = true; }, +[](loop::TickOutput& o) { o.haptics.waits = true; },
        +[](loop::TickOutput& o) { o.applied.acts = true; }}) {
    loop::TickOutput output = Quiet();
    output.gate = 0;
    change(output);
    EXPECT_EQ(PublishedFlags(output), 0U);
  }
}

}  // namespace test_daemon_publish
}  // namespace omni::daemon
