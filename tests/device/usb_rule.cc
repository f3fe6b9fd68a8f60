// manifests/udev/70-omni.rules against the USB IDs of firmware and host.
#include <gtest/gtest.h>

#include <cctype>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/wire/usb_ids.h"

namespace omni::device {
namespace test_device_usb_rule {

using Rule = std::map<std::string, std::string>;  // "ATTR{idVendor}==" -> "1209"

// One line of udev's language: key, operator, "value", commas between [udev(7)].
Rule ParseRule(const std::string& line) {
  Rule rule;
  std::size_t at = 0;
  while (at < line.size()) {
    const std::size_t open = line.find('"', at);
    const std::size_t close = open == std::string::npos ? open : line.find('"', open + 1);
    if (close == std::string::npos) break;
    std::string key = line.substr(at, open - at);
    std::erase_if(key, [](unsigned char c) { return std::isspace(c) != 0 || c == ','; });
    rule[key] = line.substr(open + 1, close - open - 1);
    at = close + 1;
  }
  return rule;
}

std::vector<Rule> ReadRules() {
  std::ifstream file(OMNI_SOURCE_DIR "/manifests/udev/70-omni.rules");
  std::vector<Rule> rules;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') rules.push_back(ParseRule(line));
  }
  return rules;
}

std::string Hex(std::uint16_t number) {
  char text[8];
  std::snprintf(text, sizeof text, "%04x", number);
  return text;
}

TEST(UdevRule, GrantsTheSeatUserAccessToTheBaseOnly) {
  const std::vector<Rule> rules = ReadRules();
  ASSERT_EQ(rules.size(), 1U);
  const Rule expected{{"SUBSYSTEM==", "usb"},
                      {"ENV{DEVTYPE}==", "usb_device"},
                      {"ATTR{idVendor}==", Hex(wire::kUsbVendorId)},
                      {"ATTR{idProduct}==", Hex(wire::kUsbProductId)},
                      {"ATTR{product}==", wire::kUsbProductName},
                      {"TAG+=", "uaccess"}};
  EXPECT_EQ(rules[0], expected);
}

}  // namespace test_device_usb_rule
}  // namespace omni::device
