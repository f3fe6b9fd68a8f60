// Exit statuses of the emulator. Test programs return their number of failures, at most kExitFailuresMax.
#pragma once

namespace omni::firmware::board {

constexpr int kExitOk = 0;
constexpr int kExitFailuresMax = 89;
constexpr int kExitUsage = 90;     // an invalid argument; the program prints which
constexpr int kExitNoLink = 91;    // the FIFOs do not exist
constexpr int kExitLinkLost = 92;  // the host closed its end, possibly in the middle of a request
constexpr int kExitException =
    100;  // + number of the exception [ARMv7-M, B1.5.2]: 3 hard fault, 4 memory, 5 bus, 6 usage

}  // namespace omni::firmware::board
