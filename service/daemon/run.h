// Runs omnid until SIGINT or SIGTERM.
#pragma once

#include <cstdint>
#include <string>

namespace omni::daemon {

struct RunOptions {
  std::string device = "twin";
  std::string device_file;
  std::string calibration_path;  // empty: the user's own, if it is there
  std::string socket_path;
  std::string record_path;
  std::string twin_script;
  std::string twin_record;
  std::uint64_t twin_seed = 1;
  std::string log_level = "info";
  bool realtime = true;
};

// Exit status for main: 0 after a signal, 1 with a message otherwise.
int Run(const RunOptions& options);

}  // namespace omni::daemon
