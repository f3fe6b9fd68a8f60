// A session on a base: its scans go in, the currents asked for come out.
#pragma once

#include <functional>

#include "service/base/result.h"
#include "service/device/transport.h"
#include "service/tools/calibrate/guided_session.h"

namespace omni::tools {

// Until the session is done, `observer` after every scan; the coils are at zero then, and after every error. The
// session begins once the base is armed. Errors: the base is gone, silent for a second, not armed within 5 s or in a
// fault; a signal (EndSignals); a step in which nothing comes forward for two minutes; a recording or a virtual run
// that ends before.
base::Status RunSession(device::Transport& transport, GuidedSession& session, const std::function<void()>& observer);

}  // namespace omni::tools
