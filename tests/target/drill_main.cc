// Prints the checksum of the core's drill: "drill STEPS CHECKSUM". The host compares it with its own.
//   drill STEPS
#include "firmware/board/mps2_an500/host_link.h"
#include "firmware/board/mps2_an500/semihosting.h"
#include "firmware/board/mps2_an500/start.h"
#include "firmware/board/mps2_an500/text.h"
#include "tests/support/drill.h"

namespace omni::firmware::board {

int Main(const char* command_line) {
  std::uint32_t steps = 0;
  if (!ParseNumber(command_line, steps)) {
    Print("drill: give the number of steps, e.g. drill 100000\n");
    return kExitUsage;
  }
  Text text;
  text.Add("drill ").Add(steps).Add(" ").AddHex(DrillChecksum(steps)).Add("\n");
  Print(text.c_str());
  return kExitOk;
}

}  // namespace omni::firmware::board
