// Runs omnid until SIGINT, SIGTERM or SIGHUP, or to the end of a replay.
#pragma once

#include <cstdint>
#include <string>

#include "service/base/result.h"

namespace omni::console {
class Program;
}

namespace omni::daemon {

struct RunOptions {
  std::string device = "usb";  // as DeviceProblem (open_device.h) allows; a simulation only on request
  std::string device_file;
  std::string calibration_path;  // empty: the user's own, if it is there
  std::string alignment_path;    // empty: the user's own
  std::string stop_path;         // empty: the user's own
  std::string socket_path;
  std::string builder_program;     // empty: omni-builder beside this program
  std::string record_path;         // ticks, as CSV
  bool replace = false;            // recordings replace files that exist
  std::string record_device_path;  // scans and commands, for --device replay:FILE
  bool replay_fast = false;
  std::string twin;  // "ideal", "room" or a file; empty: the default
  std::string twin_script;
  std::string twin_hand;  // socket on which the twin's hand is led; empty: the script is played
  std::string twin_record;
  std::uint64_t twin_seed = 1;
  std::string hand = "auto";  // "left", "right": the hand that holds the pen, unless an application's file names one
  std::string log_level = "info";
  double exit_idle_s = 0;  // ends after so long without a client; 0: never, or 60 s when systemd has passed the socket
  bool realtime = true;
};

// Exit status for main: 0 after a signal or a replay's end, 1 with a message otherwise.
int Run(const RunOptions& options);

// omnid's command line.

inline constexpr const char* kOmnidAbout =
    "omnid: tracks the pen, renders forces, serves OpenXR applications through the Omni layer";

// Parsing `omnid` writes into `options`.
void AddOptions(console::Program& omnid, RunOptions& options);

// Checks of omnid's options before anything starts.

// "--OPTION: FILE: what is wrong, what to do" for a file that is missing, malformed or cannot be written, and for
// options of the twin without the twin. Empty: no problem. Makes no file and opens no device.
std::string OptionsProblem(const RunOptions& options);

// Removes the files that --replace lets recordings replace. Only after OptionsProblem had none.
base::Status MakeWay(const RunOptions& options);

// The same with names of recordings that are free: a base that comes back is recorded to FILE.2, FILE.3, ...
RunOptions WithFreeNames(RunOptions options);

// Only the check that --twin and --ideal come with --device twin.
std::string TwinChoiceProblem(const RunOptions& options);

}  // namespace omni::daemon
