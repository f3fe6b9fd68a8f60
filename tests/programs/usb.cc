// What is taken for a base on a computer with other devices: umockdev plays the bus.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "service/base/sanitized.h"
#include "tests/support/process/program.h"

namespace omni::test {
namespace test_programs_usb {

constexpr const char* kUmockdev = "/usr/bin/umockdev-run";

// Null: it can be played. A sanitizer wants to be a program's first library, and the bus is.
const char* WhyNoBus() {
  if (!std::filesystem::exists(kUmockdev)) return "umockdev is not installed";
  return base::kSanitized ? "a sanitizer wants to be the first library of a program, and umockdev is" : nullptr;
}

Ran OnBusOf(const std::string& file, Words words) {
  words.insert(words.begin(), {kUmockdev, "-d", OMNI_SOURCE_DIR "/tests/device/data/" + file, "--"});
  return RunProgram(words);
}

// 1209:0001 is everybody's number for tests: a hobby keyboard has it, too.
TEST(Usb, KeyboardWithOurNumberIsNoBase) {
  if (const char* why = WhyNoBus()) GTEST_SKIP() << why;
  EXPECT_EQ(OnBusOf("keyboard.umockdev", {BinaryPath("omni"), "device", "list"}).out.find("KB-01"), std::string::npos);
  const Ran both = OnBusOf("keyboard_and_base.umockdev", {BinaryPath("omni"), "device", "list"});
  EXPECT_EQ(both.out.find("KB-01"), std::string::npos) << both.out;
  EXPECT_NE(both.out.find("omni-0000000001"), std::string::npos) << both.out;
}

TEST(Usb, EmergencyStopWritesToNoKeyboard) {
  if (const char* why = WhyNoBus()) GTEST_SKIP() << why;
  const Ran end = OnBusOf("keyboard.umockdev", {BinaryPath("omni"), "device", "estop"});
  EXPECT_NE(end.status, 0);
  EXPECT_EQ((end.out + end.err).find("KB-01"), std::string::npos) << end.out << end.err;
}

}  // namespace test_programs_usb
}  // namespace omni::test
