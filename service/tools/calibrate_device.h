// A calibration session on a base: its scans go in, the currents asked for come out.
#pragma once

#include <functional>

#include "service/base/result.h"
#include "service/device/transport.h"
#include "service/tools/calibrate_session.h"

namespace omni::tools {

// Sees the session after every scan.
using SessionObserver = std::function<void(const CalibrationSession&)>;

// Until the session is done; the coils are at zero then, and after every error. The session begins once the base is
// armed. Errors: the base is gone, silent for a second, not armed within 5 s or in a fault; a signal (EndSignals); a
// step in which nothing comes forward for two minutes; a recording or a virtual run that ends before.
base::Status RunSession(device::Transport& transport, CalibrationSession& session, const SessionObserver& observer);

}  // namespace omni::tools
