// What the emulated board and its host agree on: names of files, exit statuses.
#pragma once

namespace omni::firmware::board {

// Exit statuses of the emulator. Test programs return their number of failures, at most kExitFailuresMax.
constexpr int kExitOk = 0;
constexpr int kExitFailuresMax = 89;
constexpr int kExitUsage = 90;     // an invalid argument; the program prints which
constexpr int kExitNoLink = 91;    // the FIFOs do not exist
constexpr int kExitLinkLost = 92;  // the host closed its end, possibly in the middle of a request
constexpr int kExitException =
    100;  // + number of the exception [ARMv7-M, B1.5.2]: 3 hard fault, 4 memory, 5 bus, 6 usage

// Names shared by the emulated board and its host; the files are in the emulator's working directory. Requests and
// answers are those of firmware/core/lockstep_board.h.
constexpr char kToBoard[] = "to_board";      // FIFO of LockstepRequest; the board opens it first
constexpr char kFromBoard[] = "from_board";  // FIFO of LockstepAnswer; one to each request but kExit
constexpr char kReport[] = "report";         // file, written at kExit: lines "name number"
constexpr char kCount[] = "count";           // argument: count instructions into the report

}  // namespace omni::firmware::board
