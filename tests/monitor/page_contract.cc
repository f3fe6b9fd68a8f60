// The page's names are those of the service.
#include <gtest/gtest.h>

#include <bit>
#include <fstream>
#include <set>
#include <sstream>

#include "service/base/tool_state.h"
#include "service/loop/tick.h"
#include "service/monitor/page/bit_names.h"
#include "service/monitor/page/page_layout.h"
#include "service/protocol/sample_range.h"
#include "tests/monitor/contract/contract_text.h"

namespace omni::monitor {
namespace test_monitor_page_contract {

std::string TextOf(const std::string& path) {
  std::ifstream file(OMNI_SOURCE_DIR "/" + path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(PageContract, IsUpToDate) {
  const std::string program = "build/release/bin/page_contract";
  EXPECT_EQ(TextOf("service/page/src/contract.ts"), ContractTypes()) << program << " > service/page/src/contract.ts";
  EXPECT_EQ(TextOf("docs/protocol/page.json"), ContractJson()) << program << " --json > docs/protocol/page.json";
}

// The layout of a dropped file is that of the server's reader.
TEST(PageContract, DroppedFileIsReadByItsLayout) {
  PageBytes out(64);
  PutDrop(out, "a.glb", "glTF01234567");
  const std::string message = out.Take();
  const DroppedFile file = ReadDroppedFile(message);
  EXPECT_EQ(file.problem, "");
  EXPECT_EQ(file.name, "a.glb");
  EXPECT_EQ(file.bytes, "glTF01234567");
}

std::uint32_t AllOf(std::span<const BitName> names) {
  std::uint32_t all = 0;
  std::set<std::string> seen;
  for (const BitName& row : names) {
    EXPECT_TRUE(std::has_single_bit(row.mask)) << row.name;
    EXPECT_EQ(all & row.mask, 0U) << row.name;
    EXPECT_TRUE(seen.insert(row.name).second) << row.name;
    all |= row.mask;
  }
  return all;
}

TEST(PageContract, EveryBitHasAName) {
  EXPECT_EQ(AllOf(FlagNames()), protocol::kKnownToolFlags);
  EXPECT_EQ(AllOf(TickFaultNames()), loop::kFaultDevice | loop::kFaultTracking | loop::kFaultTime |
                                         loop::kFaultNotFinite | loop::kFaultCommandsStale);
  // The compiler asks for a name of each.
  EXPECT_EQ(AllOf(ToolLimitNames()), (1U << ToolLimitNames().size()) - 1) << "bits without a gap";
  EXPECT_GE(ToolLimitNames().back().mask, std::uint32_t{base::kToolFrozen});
}

}  // namespace test_monitor_page_contract
}  // namespace omni::monitor
