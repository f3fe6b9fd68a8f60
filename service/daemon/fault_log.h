// Tells people about a base's faults: each once when it comes, with what to do, and when they are over.
#pragma once

#include <string>
#include <vector>

#include "service/device/transport.h"

namespace omni::daemon {

struct FaultLine {
  bool is_problem = false;  // else good news
  std::string text;
};

class FaultLog {
 public:
  // What is new since the last call.
  std::vector<FaultLine> News(const device::TransportState& state);

 private:
  device::TransportState last_;
};

}  // namespace omni::daemon
