// omnid --device: which words it accepts; and the log of a base's faults.
#include <gtest/gtest.h>

#include "firmware/wire/names.h"
#include "service/daemon/devices/fault_log.h"
#include "service/daemon/devices/open_device.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::daemon {
namespace test_daemon_device {

TEST(DeviceWords, AcceptsKnownDevices) {
  for (const char* device : {"twin", "usb", "usb:A17", "usb:with:colon"}) {
    EXPECT_EQ(DeviceProblem(device), "") << device;
  }
}

TEST(DeviceWords, RejectsUnknownDevicesAndListsKnownOnes) {
  for (const char* device : {"", "usb:", "twin:7", "auto", "serial", ":A17"}) {
    const std::string problem = DeviceProblem(device);
    for (const char* part : {"is not a device", "twin", "usb[:SERIAL]"}) {
      EXPECT_NE(problem.find(part), std::string::npos) << device << ": " << problem;
    }
  }
}

TEST(DeviceWords, HelpDescribesEveryDevice) {
  for (const char* part : {"twin: ", "usb[:SERIAL]: ", "waits until", "simulation"}) {
    EXPECT_NE(DeviceHelp().find(part), std::string::npos) << part;
  }
}

TEST(DeviceWords, SimulationRunsOnlyWhenRequested) {
  EXPECT_FALSE(IsTwin(RunOptions{}.device));
  EXPECT_EQ(DeviceProblem(RunOptions{}.device), "");
  EXPECT_TRUE(IsTwin("twin"));
  EXPECT_FALSE(IsTwin("usb:twin"));
}

TEST(DeviceWords, OpeningAnUnknownDeviceFails) {
  RunOptions options;
  options.device = "nothing";
  EXPECT_FALSE(OpenDevice(options).ok());
}

// Readings and saturation of other sensors than those of the device file would be taken for these.
TEST(DeviceSensors, AnotherRangeThanTheDeviceFilesIsReported) {
  const base::DeviceGeometry device = support::NominalDevice();
  EXPECT_EQ(SensorProblem({.field_range_T = device.sensor_range_T}, device), "");
  EXPECT_EQ(SensorProblem({.field_range_T = device.sensor_range_T + 0.9 * device.sensor_lsb_T}, device), "")
      << "rounded";
  EXPECT_EQ(SensorProblem({}, device), "") << "a recording does not say";
  const std::string problem = SensorProblem({.field_range_T = 0.8e-3}, device);
  for (const char* part : {"0.8", "1.6", "sensor_range_T", "--device-file"})
    EXPECT_NE(problem.find(part), std::string::npos) << problem;
}

TEST(FaultLog, ReportsEachFaultOnceWithAdvice) {
  FaultLog log;
  EXPECT_TRUE(log.PopLines({.faults = wire::kFaultNotArmed | wire::kFaultHostSilent}).empty()) << "cleared by arming";
  const device::TransportState hot{.waits_for_person = true, .faults = wire::kFaultOverTemperature | wire::kFaultFan};
  const std::vector<FaultLine> news = log.PopLines(hot);
  ASSERT_EQ(news.size(), 3U);
  EXPECT_NE(news[0].text.find(wire::FaultAdvice(wire::kFaultOverTemperature)), std::string::npos) << news[0].text;
  EXPECT_NE(news[1].text.find(wire::FaultName(wire::kFaultFan)), std::string::npos) << news[1].text;
  EXPECT_NE(news[2].text.find("omni device selftest"), std::string::npos) << news[2].text;
  for (const FaultLine& line : news) EXPECT_TRUE(line.is_problem);
  EXPECT_TRUE(log.PopLines(hot).empty()) << "not again";
}

TEST(FaultLog, ReportsWhenFaultsClear) {
  FaultLog log;
  log.PopLines({.faults = wire::kFaultFan});
  const std::vector<FaultLine> news = log.PopLines({});
  ASSERT_EQ(news.size(), 1U);
  EXPECT_FALSE(news[0].is_problem);
  EXPECT_EQ(log.PopLines({.faults = wire::kFaultFan}).size(), 1U) << "a fault that comes back is news";
}

device::BaseNote FaultNote(std::uint32_t fault, std::uint8_t part, float value) {
  device::BaseNote note;
  note.type = wire::MessageType::kFault;
  note.fault.fault = note.fault.faults = fault;
  note.fault.state = wire::State::kArmed;
  note.fault.part = part;
  note.fault.value = value;
  note.fault.t_us = 1'500'000;
  return note;
}

device::BaseNote LogNote(wire::LogLevel level, const std::string& text) {
  device::BaseNote note;
  note.log.level = level;
  note.log.size = static_cast<std::uint8_t>(text.copy(note.log.text, sizeof note.log.text));
  return note;
}

TEST(FaultLog, ReportsTheFaultyPartAndTheMeasuredValue) {
  FaultLog log;
  log.AddNote(FaultNote(wire::kFaultOverTemperature, 2, 71.5F), 1);
  log.AddNote(FaultNote(wire::kFaultFan, 255, 0), 1);
  const std::vector<FaultLine> news = log.PopLines({.faults = wire::kFaultOverTemperature | wire::kFaultFan});
  ASSERT_EQ(news.size(), 2U);
  EXPECT_EQ(news[0].text.find("over temperature at coil 2, 71.5 C: "), 0U) << news[0].text;
  EXPECT_NE(news[0].text.find(wire::FaultAdvice(wire::kFaultOverTemperature)), std::string::npos) << news[0].text;
  EXPECT_EQ(news[1].text.find("fan stands, 0 1/min: "), 0U) << news[1].text;
  EXPECT_TRUE(log.PopLines({.faults = wire::kFaultOverTemperature | wire::kFaultFan}).empty()) << "each once";
}

TEST(FaultLog, ReportsFaultsThatTelemetryMissed) {
  FaultLog log;
  log.AddNote(FaultNote(wire::kFaultDriver, 1, 4), 1);
  EXPECT_TRUE(log.PopLines({}).empty()) << "telemetry may be on its way";
  const std::vector<FaultLine> news = log.PopLines({});
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(news[0].text, "driver fault at coil 1, 4 A, in state armed, 1.500 s after its start");
  EXPECT_TRUE(log.PopLines({}).empty());
}

TEST(FaultLog, HostSilenceAndStoredFaultsAreNotProblems) {
  FaultLog log;
  log.AddNote(FaultNote(wire::kFaultHostSilent, 255, 0.012F), 1);
  device::BaseNote kept = FaultNote(wire::kFaultSupplyLow, 255, 8);
  kept.fault.after_reset = 1;
  log.AddNote(kept, 2);
  log.AddNote(FaultNote(0, 0, 0), 3);
  const std::vector<FaultLine> news = log.PopLines({});
  ASSERT_EQ(news.size(), 2U) << "fault 0 is none";
  EXPECT_EQ(news[0].text.find("host silent, 0.012 s"), 0U) << news[0].text;
  EXPECT_EQ(news[1].text.find("kept from before its last reset: supply low, 8 V"), 0U) << news[1].text;
  for (const FaultLine& line : news) EXPECT_FALSE(line.is_problem);
}

TEST(FaultLog, BaseMessagesAreMadePrintable) {
  FaultLog log;
  log.AddNote(LogNote(wire::LogLevel::kWarning, "armed -> fault\x1B[31m\n"), 1);
  log.AddNote(LogNote(wire::LogLevel::kInfo, "idle -> armed"), 2);
  const std::vector<FaultLine> news = log.PopLines({});
  ASSERT_EQ(news.size(), 2U);
  EXPECT_EQ(news[0].text, "message: armed -> fault?[31m?");
  EXPECT_TRUE(news[0].is_problem);
  EXPECT_EQ(news[1].text, "message: idle -> armed");
  EXPECT_FALSE(news[1].is_problem);
}

// A base that talks without end, in words and in faults that do not exist.
TEST(FaultLog, LimitsTheRateOfBaseMessages) {
  FaultLog log;
  std::size_t lines = 0;
  constexpr std::int64_t kPoll_ns = 100'000'000;
  constexpr int kPolls = 600;  // a minute
  for (int i = 0; i < kPolls; ++i) {
    for (int k = 0; k < 60; ++k) {
      log.AddNote(
          k % 2 == 0 ? LogNote(wire::LogLevel::kError, "?") : FaultNote(0x80000000U + static_cast<unsigned>(k), 0, 1),
          i * kPoll_ns);
    }
    lines += log.PopLines({}).size();
  }
  EXPECT_GT(lines, 60U);
  EXPECT_LE(lines, 2 * (LineRate::kBurst + 60U)) << "each may be preceded by how many were left out";
  device::BaseNote late = LogNote(wire::LogLevel::kInfo, "at last");
  late.lost_before = 5;
  log.PopLines({});
  log.PopLines({});
  log.AddNote(late, 700 * kPoll_ns);
  const std::vector<FaultLine> news = log.PopLines({});
  ASSERT_EQ(news.size(), 2U);
  EXPECT_NE(news[0].text.find(" messages of the base were left out"), std::string::npos) << news[0].text;
  EXPECT_EQ(news[1].text, "message: at last");
}

}  // namespace test_daemon_device
}  // namespace omni::daemon
