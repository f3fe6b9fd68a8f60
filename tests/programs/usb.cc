// What is taken for a base on a computer with other devices: umockdev plays the bus.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/process/program.h"

namespace omni::test {
namespace test_programs_usb {

constexpr const char* kUmockdev = "/usr/bin/umockdev-run";

Ran OnBusOf(const std::string& file, Words words) {
  words.insert(words.begin(), {kUmockdev, "-d", OMNI_SOURCE_DIR "/tests/device/data/" + file, "--"});
  return RunProgram(words);
}

// 1209:0001 is everybody's number for tests: a hobby keyboard has it, too.
TEST(Usb, KeyboardWithOurNumberIsNoBase) {
  if (!std::filesystem::exists(kUmockdev)) GTEST_SKIP() << "umockdev is not installed";
  EXPECT_EQ(OnBusOf("keyboard.umockdev", {BinaryPath("omni"), "device", "list"}).out.find("KB-01"), std::string::npos);
  const Ran both = OnBusOf("keyboard_and_base.umockdev", {BinaryPath("omni"), "device", "list"});
  EXPECT_EQ(both.out.find("KB-01"), std::string::npos) << both.out;
  EXPECT_NE(both.out.find("omni-0000000001"), std::string::npos) << both.out;
}

TEST(Usb, EmergencyStopWritesToNoKeyboard) {
  if (!std::filesystem::exists(kUmockdev)) GTEST_SKIP() << "umockdev is not installed";
  const Ran end = OnBusOf("keyboard.umockdev", {BinaryPath("omni"), "device", "estop"});
  EXPECT_NE(end.status, 0);
  EXPECT_EQ((end.out + end.err).find("KB-01"), std::string::npos) << end.out << end.err;
}

}  // namespace test_programs_usb
}  // namespace omni::test
