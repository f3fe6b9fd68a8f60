// Prints docs/theory/firmware-steps.md.
#include "tests/firmware/pages/current_steps.h"

#include <cstdio>

int main() {
  using namespace omni::firmware;
  std::fputs(StepPage(MeasureHeating()).c_str(), stdout);
  return 0;
}
