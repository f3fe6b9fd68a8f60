// omnid --device: which words it knows; and what it tells people about a base's faults.
#include <gtest/gtest.h>

#include "firmware/wire/names.h"
#include "service/daemon/fault_log.h"
#include "service/daemon/open_device.h"

namespace omni::daemon {
namespace {

TEST(DeviceWords, KnownOnes) {
  for (const char* device : {"twin", "usb", "usb:A17", "usb:with:colon", "auto"}) {
    EXPECT_EQ(DeviceProblem(device), "") << device;
  }
}

TEST(DeviceWords, OthersAreRefusedWithTheList) {
  for (const char* device : {"", "usb:", "twin:7", "auto:A17", "serial", ":A17"}) {
    const std::string problem = DeviceProblem(device);
    for (const char* part : {"is no device", "twin", "usb[:SERIAL]", "auto"}) {
      EXPECT_NE(problem.find(part), std::string::npos) << device << ": " << problem;
    }
  }
}

TEST(DeviceWords, HelpSaysWhatEachIs) {
  for (const char* part : {"twin: ", "usb[:SERIAL]: ", "auto: ", "simulation"}) {
    EXPECT_NE(DeviceHelp().find(part), std::string::npos) << part;
  }
}

TEST(DeviceWords, OnlyAutoIsSettled) {
  EXPECT_EQ(SettleDevice("twin"), "twin");
  EXPECT_EQ(SettleDevice("usb:A17"), "usb:A17");
  const std::string settled = SettleDevice("auto");
  EXPECT_TRUE(settled == "twin" || settled == "usb") << settled;
}

TEST(DeviceWords, OpeningAnUnknownOneIsAnError) {
  RunOptions options;
  options.device = "nothing";
  EXPECT_FALSE(OpenDevice(options).ok());
}

TEST(FaultLog, EachFaultOnceWithAdvice) {
  FaultLog log;
  EXPECT_TRUE(log.News({.faults = wire::kFaultNotArmed | wire::kFaultHostSilent}).empty()) << "mended by arming";
  const device::TransportState hot{.waits_for_person = true, .faults = wire::kFaultOverTemperature | wire::kFaultFan};
  const std::vector<FaultLine> news = log.News(hot);
  ASSERT_EQ(news.size(), 3U);
  EXPECT_NE(news[0].text.find(wire::FaultAdvice(wire::kFaultOverTemperature)), std::string::npos) << news[0].text;
  EXPECT_NE(news[1].text.find(wire::FaultName(wire::kFaultFan)), std::string::npos) << news[1].text;
  EXPECT_NE(news[2].text.find("omni device selftest"), std::string::npos) << news[2].text;
  for (const FaultLine& line : news) EXPECT_TRUE(line.is_problem);
  EXPECT_TRUE(log.News(hot).empty()) << "not again";
}

TEST(FaultLog, SaysWhenItIsOver) {
  FaultLog log;
  log.News({.faults = wire::kFaultFan});
  const std::vector<FaultLine> news = log.News({});
  ASSERT_EQ(news.size(), 1U);
  EXPECT_FALSE(news[0].is_problem);
  EXPECT_EQ(log.News({.faults = wire::kFaultFan}).size(), 1U) << "a fault that comes back is news";
}

}  // namespace
}  // namespace omni::daemon
