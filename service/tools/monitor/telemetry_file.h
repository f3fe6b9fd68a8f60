// omni monitor --csv: every tick of a running omnid as one row of a file, without a page.
#pragma once

#include <cstdint>
#include <string>

#include "service/base/result.h"
#include "service/client/connection.h"

namespace omni::tools {

struct TelemetryCount {
  std::uint64_t rows = 0, lost = 0;
};

// To a file that is not there yet, until `seconds` have passed or a signal asks for the end. Columns as in the page's
// CSV: time_s since the first row, the channels (service/monitor/page/channels.h), t_monotonic_s. An omnid that ends
// and starts again goes on in the same file. Error: the file exists, or cannot be written.
base::Result<TelemetryCount> WriteTelemetry(client::Connection& connection, const std::string& path, double seconds);

}  // namespace omni::tools
