// Runs a session on a base: feeds it scans and sets the currents that it requests.
#pragma once

#include <functional>

#include "service/base/result.h"
#include "service/device/transport.h"
#include "service/tools/calibrate/guided_session.h"

namespace omni::tools {

// Until the session is done, `observer` after every scan; the coils are at zero then, and after every error. The
// session begins once the base is armed. Errors: the base is gone, silent for a second, not armed within 5 s or in a
// fault; a signal (EndSignals); a step without progress for two minutes; a recording or virtual run that ends early.
base::Status RunSession(device::Transport& transport, GuidedSession& session, const std::function<void()>& observer);

}  // namespace omni::tools
