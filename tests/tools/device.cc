// omni device: what it prints, what it does to a base, and its exit statuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include <nlohmann/json.hpp>

#include "firmware/wire/names.h"
#include "service/tools/common/command_line.h"
#include "service/tools/device/device.h"
#include "tests/support/chips/fake_usb.h"

namespace omni::tools {
namespace test_tools_device {

using test::FakeUsbBus;

struct Done {
  int status = -1;
  std::string out, err;
};

template <class Action>
Done Do(const Action& action) {
  std::ostringstream out;
  testing::internal::CaptureStderr();
  Done done;
  done.status = action(out);
  done.err = testing::internal::GetCapturedStderr();
  done.out = out.str();
  return done;
}

void ExpectHas(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " not in:\n" << text;
}

bool Yes() { return true; }

// Its fan stands, coil 1 is warm, and it has kept a fault.
void AddBaseWithAFault(FakeUsbBus& bus) {
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.base.keeps_fault = true;
  entry.base.state = wire::State::kFault;
  entry.base.faults = wire::kFaultFan;
  entry.base.telemetry.temperature[1] = 4210;
}

TEST(ToolsDevice, ListShowsEveryBase) {
  FakeUsbBus bus;
  bus.Add("A17", "1-1");
  FakeUsbBus::Entry& locked = bus.Add("B2", "1-2.3");
  locked.listed.problem = device::UsbPermissionHelp(locked.listed.node);
  const Done done = Do([&](std::ostream& out) { return DeviceList(bus, false, out); });
  EXPECT_EQ(done.status, kExitOk);
  ExpectHas(done.out, {"A17", "1-1", "480 Mbit/s", "1.2", "B2", "1-2.3", "70-omni.rules"});
}

TEST(ToolsDevice, EveryCommandFailsWithOneLineWithoutABase) {
  FakeUsbBus bus;
  for (const Done& done : {Do([&](std::ostream& out) { return DeviceList(bus, false, out); }),
                           Do([&](std::ostream& out) { return DeviceInfo(bus, "", false, out); }),
                           Do([&](std::ostream& out) { return DeviceSelfTest(bus, "", Yes, false, out); }),
                           Do([&](std::ostream& out) { return DeviceEstop(bus, "", out); })}) {
    EXPECT_EQ(done.status, kExitFailed);
    EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 1) << done.err;
    ExpectHas(done.err, {"omni device ", "no Omni base"});
  }
}

TEST(ToolsDevice, InfoShowsFaultsWithAdviceAndKeptFault) {
  FakeUsbBus bus(true);
  AddBaseWithAFault(bus);
  const Done done = Do([&](std::ostream& out) { return DeviceInfo(bus, "", false, out); });
  EXPECT_EQ(done.status, kExitOk) << done.err;
  ExpectHas(done.out, {"A17 at port 1-1", "1.2; speaks protocol 1 to 1", "15.00 A per coil", "42.1", "18.00 V",
                       wire::FaultName(wire::kFaultFan), wire::FaultAdvice(wire::kFaultFan),
                       "over temperature at coil 2, 71.5 C, in state armed, 12.346 s"});
}

TEST(ToolsDevice, JsonHasTheFactsOfTheText) {
  FakeUsbBus bus(true);
  AddBaseWithAFault(bus);
  const auto list = nlohmann::json::parse(Do([&](std::ostream& out) { return DeviceList(bus, true, out); }).out);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["serial"], "A17");
  EXPECT_TRUE(list[0]["problem"].is_null());
  const auto info = nlohmann::json::parse(Do([&](std::ostream& out) { return DeviceInfo(bus, "", true, out); }).out);
  EXPECT_EQ(info["current_max_A"], 15.0);
  EXPECT_EQ(info["now"]["faults"][0]["name"], wire::FaultName(wire::kFaultFan));
  EXPECT_NEAR(info["now"]["coil_temperatures_C"][1], 42.1, 1e-9);
  EXPECT_NEAR(info["now"]["supply_V"], 18, 1e-9);
  const Done tested = Do([&](std::ostream& out) { return DeviceSelfTest(bus, "", Yes, true, out); });
  const auto test = nlohmann::json::parse(tested.out);
  EXPECT_EQ(test["passed"], tested.status == kExitOk);
  EXPECT_EQ(test["tests"].size(), 8U);
}

TEST(ToolsDevice, ErrorsAreJsonTooWhereItIsAskedFor) {
  FakeUsbBus bus;
  for (const Done& done : {Do([&](std::ostream& out) { return DeviceList(bus, true, out); }),
                           Do([&](std::ostream& out) { return DeviceInfo(bus, "", true, out); }),
                           Do([&](std::ostream& out) { return DeviceSelfTest(bus, "", Yes, true, out); })}) {
    EXPECT_EQ(done.status, kExitFailed);
    ExpectHas(nlohmann::json::parse(done.out).at("error").get<std::string>(), {"no Omni base"});
  }
}

OtherPrograms Held(const std::vector<device::Holder>& holders, const base::Result<nlohmann::json>& status) {
  return {.holders = [=](const std::string&) { return holders; }, .service_status = [=] { return status; }};
}

nlohmann::json ServiceStatus(const std::string& serial) {
  return {{"device",
           {{"serial", serial},
            {"state", "fault"},
            {"faults", {"fan stands"}},
            {"waits_for_person", true},
            {"received", 1234},
            {"missed", 0},
            {"bad_frames", 2}}}};
}

// The service holds the base: endpoint 0 provides its identity, the service its state, and nothing is claimed.
TEST(ToolsDevice, InfoOfBaseInUseComesFromTheService) {
  FakeUsbBus bus;
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.open_error = "it must not be opened";
  const Done done = Do([&](std::ostream& out) {
    return DeviceInfo(bus, "", false, out, Held({{.pid = 12, .name = "omnid"}}, ServiceStatus("A17")));
  });
  EXPECT_EQ(done.status, kExitOk) << done.err;
  ExpectHas(done.out, {"A17 at port 1-1", "held by      omnid (pid 12)\n", "state        fault\n",
                       "faults       fan stands\n", wire::FaultAdvice(wire::kFaultFan), "omni device selftest",
                       "1234 frames received, 0 lost, 2 bad", "systemctl --user stop omnid"});
}

TEST(ToolsDevice, InfoOfBaseInUseExplainsMissingServiceStatus) {
  FakeUsbBus bus;
  bus.Add("A17");
  const auto info = [&](const std::string& holder, const base::Result<nlohmann::json>& status) {
    const Done done = Do(
        [&](std::ostream& out) { return DeviceInfo(bus, "", false, out, Held({{.pid = 7, .name = holder}}, status)); });
    EXPECT_EQ(done.status, kExitOk) << done.err;
    return done.out;
  };
  ExpectHas(info("omnid", base::Error{"omnid does not answer at /x"}),
            {"omnid (pid 7)", "omnid does not answer at /x"});
  const std::string other = info("omnid", ServiceStatus("B2"));
  ExpectHas(other, {"another base", "systemctl --user stop omnid"});
  EXPECT_EQ(other.find("fan stands"), std::string::npos) << other;
  const std::string stranger = info("bench", ServiceStatus("A17"));
  ExpectHas(stranger, {"bench (pid 7)", "stop that program"});
  EXPECT_EQ(stranger.find("fan stands"), std::string::npos) << stranger;
}

TEST(ToolsDevice, InfoWithTwoBasesRequiresASerial) {
  FakeUsbBus bus(true);
  bus.Add("A17", "1-1");
  bus.Add("B2", "1-2");
  const Done unclear = Do([&](std::ostream& out) { return DeviceInfo(bus, "", false, out); });
  EXPECT_EQ(unclear.status, kExitFailed);
  ExpectHas(unclear.err, {"A17", "B2", "SERIAL"});
  EXPECT_EQ(Do([&](std::ostream& out) { return DeviceInfo(bus, "B2", false, out); }).status, kExitOk);
}

TEST(ToolsDevice, SelfTestPassesAGoodBase) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  const Done done = Do([&](std::ostream& out) { return DeviceSelfTest(bus, "A17", Yes, false, out); });
  EXPECT_EQ(done.status, kExitOk) << done.err << done.out;
  EXPECT_EQ(done.out.find("FAIL"), std::string::npos) << done.out;
  for (const wire::Command& command : entry.base.commands) EXPECT_EQ(command.mode, wire::Mode::kOff);
}

TEST(ToolsDevice, SelfTestDoesNothingWithoutConfirmation) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  const Done done = Do([&](std::ostream& out) {
    return DeviceSelfTest(
        bus, "", [] { return false; }, false, out);
  });
  EXPECT_EQ(done.status, kExitFailed);
  EXPECT_EQ(bus.link, nullptr) << "the base was not even opened";
  EXPECT_TRUE(entry.base.seqs.empty());
}

TEST(ToolsDevice, SelfTestSaysWhatFails) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.base.state = wire::State::kFault;
  entry.base.faults = wire::kFaultSupplyLow;
  entry.base.refuses_arm = wire::kFaultSupplyLow;
  const Done done = Do([&](std::ostream& out) { return DeviceSelfTest(bus, "", Yes, false, out); });
  EXPECT_EQ(done.status, kExitFailed);
  ExpectHas(done.out, {"FAIL  supply", "FAIL  arming", wire::FaultName(wire::kFaultSupplyLow)});
}

device::UsbProbe GoodProbe() {
  device::UsbProbe probe;
  probe.hello = test::GoodUsbHello("A17");
  probe.frames = 1001;
  probe.listened_s = 1;
  probe.fresh_sensors = 0xFF;
  probe.armed = true;
  return probe;
}

bool Passed(const device::UsbProbe& probe, const std::string& name) {
  for (const SelfTestRow& row : JudgeSelfTest(probe)) {
    if (row.name == name) return row.passed;
  }
  ADD_FAILURE() << name;
  return false;
}

TEST(ToolsDevice, SelfTestDetectsEachKindOfDefect) {
  for (const SelfTestRow& row : JudgeSelfTest(GoodProbe())) EXPECT_TRUE(row.passed) << row.name;
  device::UsbProbe probe = GoodProbe();
  probe.listened_s = 1.1;
  EXPECT_FALSE(Passed(probe, "telemetry"));
  probe.frames = 0;
  EXPECT_FALSE(Passed(probe, "telemetry"));
  probe = GoodProbe();
  probe.missed = 1;
  EXPECT_FALSE(Passed(probe, "frames"));
  probe = GoodProbe();
  probe.fresh_sensors = 0xF7;
  EXPECT_FALSE(Passed(probe, "Hall sensors"));
  ExpectHas(SelfTestText(JudgeSelfTest(probe)), {"no new sample from 3"});
  probe = GoodProbe();
  probe.saturated_mask = 1U << 16;
  EXPECT_FALSE(Passed(probe, "Hall sensors"));
  ExpectHas(SelfTestText(JudgeSelfTest(probe)), {"saturated: 5"});
  probe = GoodProbe();
  probe.armed = false;
  EXPECT_FALSE(Passed(probe, "arming"));
  probe.hello.capabilities = 0;
  EXPECT_TRUE(Passed(probe, "arming"));
}

TEST(ToolsDevice, EstopStopsEveryBaseOrTheOneNamed) {
  FakeUsbBus bus;
  FakeUsbBus::Entry& first = bus.Add("A17", "1-1");
  FakeUsbBus::Entry& second = bus.Add("B2", "1-2");
  first.open_error = "another program holds it";  // endpoint 0 needs no claim
  EXPECT_EQ(Do([&](std::ostream& out) { return DeviceEstop(bus, "", out); }).status, kExitOk);
  EXPECT_EQ(first.base.stops, 1);
  EXPECT_EQ(second.base.stops, 1);
  EXPECT_EQ(Do([&](std::ostream& out) { return DeviceEstop(bus, "B2", out); }).status, kExitOk);
  EXPECT_EQ(first.base.stops, 1);
  EXPECT_EQ(second.base.stops, 2);
}

TEST(ToolsDevice, FailedEstopIsReportedAndOthersStillStop) {
  FakeUsbBus bus;
  bus.Add("A17", "1-1").control_error = "no answer";
  FakeUsbBus::Entry& second = bus.Add("B2", "1-2");
  const Done done = Do([&](std::ostream& out) { return DeviceEstop(bus, "", out); });
  EXPECT_EQ(done.status, kExitFailed);
  EXPECT_EQ(second.base.stops, 1);
  ExpectHas(done.err, {"NOT STOPPED", "switch the coils' supply off", "usb base A17: no answer"});
}

Done Omni(std::initializer_list<const char*> words) {
  std::vector<const char*> argv{"omni", "device"};
  argv.insert(argv.end(), words);
  testing::internal::CaptureStdout();
  Done done = Do([&](std::ostream&) { return RunCommandLine(static_cast<int>(argv.size()), argv.data()); });
  done.out = testing::internal::GetCapturedStdout();
  return done;
}

TEST(ToolsDevice, WrongArgumentsExitWithStatus2) {
  EXPECT_EQ(Omni({}).status, kExitUsage);
  EXPECT_EQ(Omni({"dance"}).status, kExitUsage);
  EXPECT_EQ(Omni({"list", "A17"}).status, kExitUsage);
  EXPECT_EQ(Omni({"info", "A17", "B2"}).status, kExitUsage);
  EXPECT_EQ(Omni({"estop", "--yes"}).status, kExitUsage);
}

TEST(ToolsDevice, HelpListsCommandsAndFlashHelpGivesSteps) {
  const Done help = Omni({"flash-help"});
  EXPECT_EQ(help.status, kExitOk);
  ExpectHas(help.out, {"teensy_loader_cli --mcu=TEENSY40", "firmware/README.md", "omni device selftest"});
  ExpectHas(Omni({"--help"}).out, {"list", "info", "selftest", "flash-help", "estop"});
}

}  // namespace test_tools_device
}  // namespace omni::tools
