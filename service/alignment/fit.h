// The one least-squares problem behind all methods: base in space, the controller's tip and a time offset, jointly.
#pragma once

#include "service/alignment/types.h"
#include "service/base/result.h"

namespace omni::alignment {

// Samples in the order of time. Rejects what cannot make a good base pose; the error says what to do.
base::Result<Outcome> FitBasePose(const std::vector<Sample>& samples, const Prior& prior, const Limits& limits);

// Checks what Limits requires of the points alone, before a fit. `what` names them: "marks", "places".
base::Status CheckGeometry(const std::vector<Sample>& samples, const Limits& limits, const std::string& what);

// Of touches: fits, and with four groups or more finds the one that does not fit the others, leaves it out and names it
// in `wrong_group`.
base::Result<Outcome> FitTouches(const std::vector<Sample>& samples, const Prior& prior, const Limits& limits);

}  // namespace omni::alignment
