// Prints docs/protocol/faults.md.
#include <cstdio>

#include "tests/firmware/fault_matrix.h"

int main() {
  std::fputs(omni::firmware::FaultPage(omni::firmware::MeasureFaultMatrix()).c_str(), stdout);
  return 0;
}
