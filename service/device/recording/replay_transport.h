// A recording as a transport: returns its scans, each once and in order. The host's commands have no effect; they are
// compared with those of the recording.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/device/recording/recording_reader.h"
#include "service/device/transport.h"

namespace omni::device {

enum class ReplayPace : std::uint8_t {
  kRecorded,  // scans arrive at their recorded intervals, with stamps moved to now
  kFast       // virtual time: at once, with their recorded stamps
};

// Commands of the host compared with those of the recording, in their order between two scans.
struct ReplayComparison {
  std::uint64_t same = 0;  // all three currents equal
  std::uint64_t different = 0;
  std::uint64_t extra = 0;    // written now, not in the recording
  std::uint64_t missing = 0;  // in the recording, not written now; those after the last scan do not count
  double largest_difference_A = 0;
};

class ReplayTransport : public Transport {
 public:
  virtual ReplayComparison comparison() const noexcept = 0;  // any thread
  virtual const RecordingSummary& summary() const noexcept = 0;
};

// Checks the whole file first; one without a scan is refused. Read returns kEnd after the last scan.
base::Result<std::unique_ptr<ReplayTransport>> OpenReplay(const std::string& path, ReplayPace pace);

}  // namespace omni::device
