// The magnets of pens that were used with a base: read when a device is opened, handed to the tracker, and extended
// when the tracker has learnt another one. On the thread that keeps the device, which does not wait for the disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/base/tool_state.h"
#include "service/config/files/magnets_file.h"
#include "service/daemon/file_writer.h"
#include "service/room/room_finding.h"
#include "service/tracker/room/magnet.h"

namespace omni::daemon {

class MagnetBook {
 public:
  // An empty path: nothing is stored. A file that cannot be read is never overwritten.
  explicit MagnetBook(std::string path, FileWriter::Write write);

  // A device is opened, with this calibration. Sets the magnets known of it.
  void LoadKnownMagnets(const std::string& serial, double calibrated_moment_Am2, tracker::MagnetOptions& options);

  // A sample of the loop. True: a magnet was added, and is being written.
  bool AddSample(const base::ToolState& tool, std::int64_t now_unix_s);
  // Now and then: results of writing. True: problem() has changed.
  bool HandleWritten();

  // Why the file is not used or could not be written.
  const std::optional<room::RoomFinding>& problem() const noexcept { return problem_; }

 private:
  void Drop(const std::string& what, const std::string& fix);

  const std::string path_;
  FileWriter writer_;
  tracker::MagnetOptions options_;  // of sigmas
  bool readable_ = true;
  std::vector<config::MagnetEntry> entries_;
  std::string serial_;
  double calibrated_moment_Am2_ = 0;  // 0: no device, or not calibrated
  std::optional<room::RoomFinding> problem_;
};

}  // namespace omni::daemon
