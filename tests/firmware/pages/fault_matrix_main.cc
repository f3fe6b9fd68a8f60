// Prints docs/protocol/faults.md.
#include <cstdio>

#include "tests/firmware/pages/fault_matrix.h"

int main() {
  using namespace omni::firmware;
  std::fputs(FaultPage(MeasureFaultMatrix(), MeasureSilence()).c_str(), stdout);
  return 0;
}
