// Faults of a working base, through the whole chain: plant, control core, emulated USB, the unmodified omnid and an
// application that presses against a block. All in device time.
#include <gtest/gtest.h>

#include <cstdio>
#include <optional>
#include <string>

#include "firmware/wire/messages.h"
#include "tests/hil/board/tools.h"
#include "tests/hil/hil_session.h"

namespace omni::hil {
namespace {

using nlohmann::json;

constexpr double kFaultZero_ms = 20;  // from the cause; a silent host is one
// The coils' resistance cannot be measured below 1 A, so a hot coil may get that much, and for some milliseconds more
// until it is measured: root mean square. 15 A would be full current; this is a hundredth of its heat.
constexpr double kHotMax_A = 1.5;
constexpr double kBack_ms = 2000;  // the service searches for its base every second

// Checks of the scenario's summary. Reactions are in the order of the scenario's events.
struct Expected {
  const char* scenario;
  void (*check)(const json& summary);
};

std::uint32_t Faults(const json& reaction) { return reaction["faults"].get<std::uint32_t>(); }

// For every run: the programs' actions happened at their virtual instants.
void ExpectVirtual(const json& summary) {
  EXPECT_EQ(summary["unsettled"], 0) << summary["unsettled_by"];
  EXPECT_EQ(summary["lost_to_core"], 0);
}
void ExpectZero(const json& reaction, double within_ms) {
  EXPECT_GT(reaction["peak_A"].get<double>(), 0.3) << "there was no current to remove";
  EXPECT_LE(reaction["zero_ms"].get<double>(), within_ms) << reaction["what"];
}
void ExpectBack(const json& reaction) {
  ASSERT_TRUE(reaction["back_ms"].is_number()) << reaction["what"] << ": no force again";
  EXPECT_LE(reaction["back_ms"].get<double>(), kBack_ms);
  EXPECT_EQ(Faults(reaction), 0U);
}
// Damaged frames alone do not remove the force.
void ExpectServed(const json& reaction) {
  EXPECT_EQ(reaction["faults_seen"], 0U) << reaction["what"];
  EXPECT_GT(reaction["peak_A"].get<double>(), 0.3) << reaction["what"];
}

const Expected kExpected[] = {
    {"steady",
     [](const json& summary) {
       EXPECT_GT(summary["contact_s"].get<double>(), 2.9);
       EXPECT_EQ(summary["lost_to_host"], 0);
       EXPECT_GT(summary["peak_A"].get<double>(), 0.3);
       EXPECT_EQ(summary["faults"], 0U);
       EXPECT_EQ(summary["rejected"], 0);
     }},
    {"replug",
     [](const json& summary) {
       ExpectZero(summary["reactions"][0], kFaultZero_ms);
       EXPECT_GE(summary["usb"]["aborted"].get<int>(), 1) << "transfers were in flight";
       EXPECT_EQ(summary["usb"]["plugged"], 2);
       ExpectBack(summary["reactions"][1]);
     }},
    {"crc",
     [](const json& summary) {
       ExpectServed(summary["reactions"][0]);
       ExpectZero(summary["reactions"][1], kFaultZero_ms);
       ExpectBack(summary["reactions"][2]);
       EXPECT_GE(summary["rejected"].get<int>(), summary["to_base"]["corrupted"].get<int>());
       EXPECT_GT(summary["to_base"]["corrupted"].get<int>(), 100);
       EXPECT_GT(summary["to_host"]["corrupted"].get<int>(), 30);
     }},
    {"silence",
     [](const json& summary) {
       ExpectZero(summary["reactions"][0], kFaultZero_ms);
       EXPECT_NE(Faults(summary["reactions"][0]) & wire::kFaultHostSilent, 0U);
       ExpectBack(summary["reactions"][1]);
     }},
    {"kill",
     [](const json& summary) {
       ExpectZero(summary["reactions"][0], kFaultZero_ms);
       EXPECT_EQ(summary["host_status"], 128 + 9);
     }},
    {"heat",
     [](const json& summary) {
       EXPECT_GT(summary["reactions"][0]["hottest_C"].get<double>(), 75);
       EXPECT_LT(summary["reactions"][0]["hot_A"].get<double>(), kHotMax_A);
     }},
    {"estop",
     [](const json& summary) {
       ExpectZero(summary["reactions"][0], kFaultZero_ms);
       EXPECT_NE(Faults(summary["reactions"][1]) & wire::kFaultEmergencyStop, 0U) << "latched until the user checks it";
       EXPECT_EQ(summary["reactions"][1]["zero_ms"], 0.0);
     }},
    {"stuck",
     [](const json& summary) {
       ExpectZero(summary["reactions"][0], 2 * kFaultZero_ms);
       EXPECT_NE(Faults(summary["reactions"][0]) & wire::kFaultHallStuck, 0U);
     }},
    {"bridge",
     [](const json& summary) {
       ExpectZero(summary["reactions"][0], kFaultZero_ms);
       EXPECT_NE(Faults(summary["reactions"][0]) & wire::kFaultDriver, 0U);
     }},
};

void Show(const std::string& name, const HilSession& session, const json& summary) {
  std::printf("%-8s wall %5.1f s, device %5.2f s, %5.0f steps/s, %d of %d ticks unsettled %s, peak %.2f A\n",
              name.c_str(), session.wall_s(), summary["device_s"].get<double>(), summary["steps_per_s"].get<double>(),
              summary["unsettled"].get<int>(), summary["ticks"].get<int>(),
              summary["unsettled_by"].get<std::string>().c_str(), summary["peak_A"].get<double>());
  for (const json& reaction : summary["reactions"]) {
    std::printf("         %-24s at zero %6.2f ms after it, faults %05x\n", reaction["what"].get<std::string>().c_str(),
                reaction["zero_ms"].get<double>(), Faults(reaction));
  }
}

// The core in an emulated Cortex-M7 instead of this process.
TEST(HilEmulatedCore, SilenceScenarioPassesOnTheEmulatedBoard) {
  OMNI_NEEDS_BOARD();
  HilSession session;
  const json summary = session.Run("silence", {"--board", "qemu"});
  ASSERT_TRUE(summary.is_object()) << "no summary";
  ASSERT_EQ(summary["problem"], "");
  Show("qemu", session, summary);
  ExpectVirtual(summary);
  ExpectZero(summary["reactions"][0], kFaultZero_ms);
  ExpectBack(summary["reactions"][1]);
}

class HilScenario : public testing::TestWithParam<Expected> {};

TEST_P(HilScenario, MeetsItsExpectations) {
  HilSession session;
  const json summary = session.Run(GetParam().scenario);
  ASSERT_TRUE(summary.is_object()) << "no summary";
  ASSERT_EQ(summary["problem"], "");
  Show(GetParam().scenario, session, summary);
  ExpectVirtual(summary);
  GetParam().check(summary);
}

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.scenario; }

INSTANTIATE_TEST_SUITE_P(All, HilScenario, testing::ValuesIn(kExpected),
                         [](const auto& expected) { return std::string(expected.param.scenario); });

}  // namespace
}  // namespace omni::hil
