// Prints firmware/board/mps2_an500/budget.txt as it is measured now.
#include <cstdio>

#include "tests/hil/board/budget.h"
#include "tests/hil/board/tools.h"

int main() {
  if (const std::string reason = omni::hil::NoBoardReason(); !reason.empty()) {
    std::fprintf(stderr, "omni_hil_budget: %s\n", reason.c_str());
    return 1;
  }
  const auto budget = omni::hil::MeasureBudget();
  if (!budget) {
    std::fprintf(stderr, "omni_hil_budget: %s\n", budget.error().c_str());
    return 1;
  }
  std::printf("%s", omni::hil::BudgetPage(*budget).c_str());
  return 0;
}
