// page_contract > service/page/src/contract.ts
#include <cstdio>

#include "tests/monitor/contract/contract_text.h"

int main() {
  std::fputs(omni::monitor::ContractText().c_str(), stdout);
  return 0;
}
