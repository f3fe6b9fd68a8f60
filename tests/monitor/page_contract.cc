// The page's names are those of the service.
#include <gtest/gtest.h>

#include <bit>
#include <fstream>
#include <set>
#include <sstream>

#include "service/base/tool_state.h"
#include "service/loop/tick.h"
#include "service/monitor/page/bit_names.h"
#include "service/protocol/sample_range.h"
#include "tests/monitor/contract/contract_text.h"

namespace omni::monitor {
namespace test_monitor_page_contract {

TEST(PageContract, IsUpToDate) {
  std::ifstream file(OMNI_SOURCE_DIR "/service/page/src/contract.ts");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), ContractText()) << "build/release/bin/page_contract > service/page/src/contract.ts";
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
  EXPECT_EQ(AllOf(ToolLimitNames()), 2U * base::kToolFrozen - 1) << "the last limit, and all before";
}

}  // namespace test_monitor_page_contract
}  // namespace omni::monitor
