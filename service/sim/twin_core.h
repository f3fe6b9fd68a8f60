// One simulated base with pen and hand, advanced one device tick at a time. It knows no sockets and no clocks: time is
// an argument. The virtual twin and the served twin both drive this class.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "firmware/wire/messages.h"
#include "service/base/device_geometry.h"
#include "service/sim/coil_drive.h"
#include "service/sim/hand.h"
#include "service/sim/recording.h"
#include "service/sim/tick_sampler.h"
#include "service/sim/truth_model.h"
#include "service/sim/twin.h"

namespace omni::sim {

class TwinCore {
 public:
  // Precondition: that of HandPath. The core does not open options.recording_path.
  TwinCore(const base::DeviceGeometry& device, const TwinOptions& options);

  wire::Hello Hello() const noexcept;

  // A valid command. It acts truth.driver.delay_s after the end of the last tick.
  void Command(const wire::Command& command, std::uint16_t seq) noexcept;
  void CountRejected() noexcept { ++telemetry_.rejected; }
  void CountMissed(std::int64_t ticks) noexcept {
    telemetry_.missed_ticks = static_cast<std::uint16_t>(telemetry_.missed_ticks + ticks);
  }

  // Advances 1 ms. `host_silence_s`: since the last valid command, for the watchdog.
  void Tick(double host_silence_s) noexcept;

  // Of the last tick. `clock_offset_ns` turns device time (0 at start) into CLOCK_MONOTONIC.
  const wire::Telemetry& telemetry() const noexcept { return telemetry_; }
  std::int64_t newest_sample_ns() const noexcept { return newest_sample_ns_; }
  std::int64_t now_ns() const noexcept { return now_ns_; }
  std::uint64_t tick() const noexcept { return tick_; }
  TruthRow Truth(std::int64_t clock_offset_ns) const noexcept;

 private:
  void Advance() noexcept;
  void Report() noexcept;

  base::DeviceGeometry device_;
  Random random_;
  Imperfections imperfections_;
  TruthModel truth_;
  CoilDrive drive_;
  Hand hand_;
  TickSampler sampler_;
  Surroundings surroundings_;
  ForceMap forces_;
  wire::Telemetry telemetry_;
  std::int64_t now_ns_ = 0;
  std::int64_t newest_sample_ns_ = 0;
  std::uint64_t tick_ = 0;
  double command_age_s_ = 0;
};

}  // namespace omni::sim
