// `omni align` with a person in front of it: the probe's poses and the pen's into a session, its steps onto the
// terminal.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/client/connection.h"
#include "service/tools/align/align_service.h"
#include "service/tools/align/align_session.h"

namespace omni::tools {

struct AlignRunOptions {
  AlignOptions session;
  std::string hand = "auto";  // left, right; auto: whichever moves first
  std::string probe;
  double patience_s = 120;  // gives up after this time
};

struct Aligned {
  Headset headset;
  alignment::Outcome outcome;
  base::Vec3 mark_space_m;  // of AlignMethod::kCheck
};

// Prints steps and progress. Ends with a placement, a refusal, the end of patience or of the runtime's session, or a
// signal.
base::Result<Aligned> RunAlignment(client::Connection& connection, const AlignRunOptions& options);

}  // namespace omni::tools
