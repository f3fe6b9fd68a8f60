// What `omni status` and `omni watch` show.
#pragma once

#include <string>

#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>

#include "service/protocol/state_memory.h"

namespace omni::tools {

// The service's status for people.

// Missing keys show as "-": the service may be of another version.
std::string StatusText(const nlohmann::json& status);

// What `omni watch` shows: a pure function of what was read.
struct WatchFrame {  // NOLINT(bugprone-exception-escape): the JSON library's move is noexcept and only asserts
  bool connected = false;
  std::string problem;  // why not, and what to do
  bool has_sample = false;
  std::int64_t now_ns = 0;
  protocol::ToolSample sample;
  protocol::InputSnapshot inputs;
  double tick_rate_Hz = 0;  // NaN: not known yet
  nlohmann::json status;    // the service's, once a second; may be null
};

// Lines of at most `columns` characters, each ending with a newline.
std::string WatchScreen(const WatchFrame& frame, int columns);

// One line, for pipes and logs.
std::string WatchLine(const WatchFrame& frame);

// "#####-----": `value` of `full` in `width` characters. Not finite: all dashes.
std::string TextBar(double value, double full, int width);

}  // namespace omni::tools
