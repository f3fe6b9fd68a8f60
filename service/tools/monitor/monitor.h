// What `omni monitor` and `omni try` use beside the monitor.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "service/base/result.h"
#include "service/client/connection.h"
#include "service/tools/common/child_program.h"

namespace omni::tools {

// What omni monitor and omni try have in common.

// The folder of the page's files. The error says that they were not built, and what works without.
base::Result<std::string> FindPage();

// Opens an address in the user's browser, if there is one and a display to show it on. False: there is not.
bool OpenBrowser(const std::string& address);

// omnid with the digital twin, for omni try: a service of its own, that ends with this process.
class TrialService {
 public:
  // Starts omnid on a socket in a folder that only the user can enter. `twin_record`: a CSV file of the twin's truth;
  // empty: none.
  static base::Result<std::unique_ptr<TrialService>> Start(const std::string& twin_record);

  const std::string& folder() const { return folder_.path(); }
  std::string socket() const { return folder() + kSocketName; }
  std::string hand() const { return folder() + kHandName; }

  // Empty while omnid runs; else how it ended, with the last line of its log.
  std::string EndReason();

 private:
  static constexpr const char* kSocketName = "/omnid.sock";
  static constexpr const char* kHandName = "/hand.sock";

  TrialService(PrivateFolder folder, ChildProgram omnid) : folder_(std::move(folder)), omnid_(std::move(omnid)) {}

  PrivateFolder folder_;
  ChildProgram omnid_;
};

// omni monitor --csv: every tick of a running omnid as one row of a file, without a page.
struct TelemetryCount {
  std::uint64_t rows = 0, lost = 0;
};

// To a file that is not there yet, until `seconds` have passed or a signal asks for the end. Columns as in the page's
// CSV: time_s since the first row, the channels (service/monitor/page/channels.h), t_monotonic_s. An omnid that ends
// and starts again goes on in the same file. Error: the file exists, or cannot be written.
base::Result<TelemetryCount> WriteTelemetry(client::Connection& connection, const std::string& path, double seconds);

}  // namespace omni::tools
