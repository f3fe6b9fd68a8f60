// A recording as a transport: gives its scans back, each once and in their order. What the host writes moves nothing;
// it is compared with what was written when the recording was made.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/device/recording/recording_reader.h"
#include "service/device/transport.h"

namespace omni::device {

enum class ReplayPace : std::uint8_t {
  kRecorded,  // scans come when they came then, and their stamps are moved to now
  kFast       // virtual time: at once, with the stamps of then
};

// Commands of the host against those of the recording, in the order between two scans.
struct ReplayComparison {
  std::uint64_t same = 0;  // all three currents equal
  std::uint64_t different = 0;
  std::uint64_t extra = 0;    // written now, not then
  std::uint64_t missing = 0;  // written then, not now; those behind the last scan do not count
  double largest_difference_A = 0;
};

class ReplayTransport : public Transport {
 public:
  virtual ReplayComparison comparison() const noexcept = 0;  // any thread
  virtual const RecordingSummary& summary() const noexcept = 0;
};

// Checks the whole file first; one without a scan is refused. Read says kEnd behind the last scan.
base::Result<std::unique_ptr<ReplayTransport>> OpenReplay(const std::string& path, ReplayPace pace);

}  // namespace omni::device
