// Names shared by the emulated board and its host; the files are in the emulator's working directory. Requests and
// answers are those of firmware/core/lockstep.h.
#pragma once

namespace omni::firmware::board {

constexpr char kToBoard[] = "to_board";      // FIFO of LockstepRequest; the board opens it first
constexpr char kFromBoard[] = "from_board";  // FIFO of LockstepAnswer; one to each request but kExit
constexpr char kReport[] = "report";         // file, written at kExit: lines "name number"
constexpr char kCount[] = "count";           // argument: count instructions into the report

}  // namespace omni::firmware::board
