// The twin in virtual time: Read() is the clock.
#include <cmath>
#include <cstdio>
#include <utility>

#include "service/device/transport.h"
#include "service/sim/twin/loopback.h"

namespace omni::sim {
namespace {

class VirtualTwin final : public device::Transport {
 public:
  VirtualTwin(const base::DeviceGeometry& device, const TwinOptions& options, double duration_s)
      : base_(device, PlantOptionsOf(options)),
        guide_(options.guide),
        ticks_(static_cast<std::uint64_t>(std::llround(duration_s / base::kTickPeriod_s))) {
    info_ = {.name = "twin (simulation, virtual time)", .serial = "twin", .simulation = true, .virtual_time = true};
    if (options.recording_path.empty()) return;
    base::Result<std::unique_ptr<Recording>> recording = Recording::Open(options.recording_path);
    if (recording) {
      recording_ = std::move(recording.value());
    } else {
      std::fprintf(stderr, "%s\n", recording.error().c_str());
    }
  }

  device::ReadStatus Read(base::HallScan& scan, std::int64_t /*timeout_ns*/) noexcept override {
    if (base_.core().tick() >= ticks_) return device::ReadStatus::kEnd;
    HandAim aim;
    if (guide_ != nullptr && guide_->Poll(aim)) base_.SetAim(aim);
    base_.Tick(scan);
    if (recording_) recording_->Add(base_.core().Truth());
    ++counters_.received;
    return device::ReadStatus::kScan;
  }

  bool Write(const base::CoilCurrents& currents) noexcept override {
    const bool sent = base_.Write(currents);
    ++(sent ? counters_.sent : counters_.send_failed);
    return sent;
  }

  const device::TransportInfo& info() const noexcept override { return info_; }
  device::TransportCounters counters() const noexcept override { return counters_.Snapshot(); }

 private:
  Loopback base_;
  std::shared_ptr<HandGuide> guide_;
  std::uint64_t ticks_;
  device::TransportInfo info_;
  device::Counters counters_;
  std::unique_ptr<Recording> recording_;
};

}  // namespace

std::unique_ptr<device::Transport> MakeVirtualTwin(const base::DeviceGeometry& device, const TwinOptions& options,
                                                   double duration_s) {
  return std::make_unique<VirtualTwin>(device, options, duration_s);
}

}  // namespace omni::sim
