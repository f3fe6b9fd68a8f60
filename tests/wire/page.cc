// docs/protocol/wire.md is the output of wire_page, and every value on the wire has a name.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "firmware/wire/names.h"

namespace omni::wire {
namespace test_wire_page {

std::string OutputOf(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 4096> part{};
  for (std::size_t size = 0; (size = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    text.append(part.data(), size);
  return pclose(pipe) == 0 ? text : "";
}

TEST(WirePage, GeneratedPageMatchesCommittedPage) {
  std::ifstream file(OMNI_SOURCE_DIR "/docs/protocol/wire.md");
  const std::string committed{std::istreambuf_iterator<char>(file), {}};
  const std::string printed = OutputOf("'" OMNI_BINARY_DIR "/bin/wire_page'");
  ASSERT_FALSE(printed.empty());
  EXPECT_TRUE(printed == committed) << "run " OMNI_BINARY_DIR "/bin/wire_page > docs/protocol/wire.md";
}

TEST(WireNames, EveryFaultBitHasNameMeaningAndAdvice) {
  std::uint32_t all = 0;
  std::set<std::string> names;
  for (const FaultText& row : FaultTexts()) {
    EXPECT_EQ(row.fault, 1U << names.size()) << "in order, without a hole";
    all |= row.fault;
    names.insert(row.name);
    EXPECT_STREQ(FaultName(row.fault), row.name);
    EXPECT_STREQ(FaultAdvice(row.fault), row.advice);
    EXPECT_EQ(row.advice[std::char_traits<char>::length(row.advice) - 1], '.') << row.name;
    EXPECT_GT(std::char_traits<char>::length(row.meaning), 0U) << row.name;
  }
  EXPECT_EQ(all, (kFaultInternal << 1) - 1) << "kFaultInternal is the last bit";
  EXPECT_EQ(names.size(), FaultTexts().count);
}

TEST(WireNames, LookupByValueReturnsNameOrUnknown) {
  EXPECT_STREQ(MessageTypeName(MessageType::kEstop), "ESTOP");
  EXPECT_STREQ(StateName(State::kFault), "fault");
  EXPECT_STREQ(ModeName(Mode::kCurrent), "current");
  EXPECT_STREQ(ArmStepName(ArmStep::kChallenge), "challenge");
  EXPECT_STREQ(ConfigOpName(ConfigOp::kRefused), "refused");
  EXPECT_STREQ(LogLevelName(LogLevel::kWarning), "warning");
  EXPECT_STREQ(ConfigIdName(0x12), "resistance_20C_ohm");
  EXPECT_STREQ(ConfigIdName(0x22), "inductance_H");
  EXPECT_STREQ(ConfigIdName(0x23), "unknown");
  EXPECT_STREQ(StateName(static_cast<State>(77)), "unknown");
  EXPECT_STREQ(FaultName(0), "unknown");
  EXPECT_STREQ(FaultName(kFaultDriver | kFaultFan), "unknown");
  EXPECT_NE(std::string(FaultAdvice(1U << 31)).find("Update"), std::string::npos);
}

// A value that decoding accepts has a name; the one behind the last has none.
TEST(WireNames, TablesEndWhereTheEnumsEnd) {
  EXPECT_EQ(MessageTypes().count, static_cast<std::size_t>(MessageType::kLog));
  EXPECT_EQ(StateNames().count, static_cast<std::size_t>(State::kFault) + 1);
  EXPECT_EQ(ModeNames().count, static_cast<std::size_t>(Mode::kCurrent) + 1);
  EXPECT_EQ(ArmSteps().count, static_cast<std::size_t>(ArmStep::kRefused));
  EXPECT_EQ(ConfigOps().count, static_cast<std::size_t>(ConfigOp::kRefused));
  EXPECT_EQ(LogLevels().count, static_cast<std::size_t>(LogLevel::kError) + 1);
  EXPECT_EQ(CapabilityNames().count, 4U);
}

}  // namespace test_wire_page
}  // namespace omni::wire
