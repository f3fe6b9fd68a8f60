// page_contract > service/page/src/contract.ts
// page_contract --json > docs/protocol/page.json
#include <cstdio>
#include <string_view>

#include "tests/monitor/contract/contract_text.h"

int main(int argc, char** argv) {
  const bool json = argc > 1 && std::string_view(argv[1]) == "--json";
  std::fputs((json ? omni::monitor::ContractJson() : omni::monitor::ContractTypes()).c_str(), stdout);
  return 0;
}
