// One simulated base with pen and hand, advanced one device tick at a time: the plant, and the firmware's control core
// that reads and drives it. It knows no sockets and no clocks: time is an argument. Virtual twin, served twin and
// traces drive this class.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/core.h"
#include "firmware/wire/messages.h"
#include "service/base/device_geometry.h"
#include "service/sim/coils/plant.h"
#include "service/sim/fields/random.h"
#include "service/sim/twin/recording.h"
#include "service/sim/twin/twin.h"

namespace omni::sim {

// Without the recording, which the core does not open.
PlantOptions PlantOptionsOf(const TwinOptions& options);

class TwinCore {
 public:
  // The base has been on for a while: at options.start_ns its self-test is over and it waits to be armed. Its clock is
  // device time plus `clock_offset_ns`, so that it can be the host's. Precondition: that of HandPath.
  TwinCore(const base::DeviceGeometry& device, const PlantOptions& options, std::int64_t clock_offset_ns);

  // A frame from the host; handled in the next tick's first control step.
  void Receive(const std::uint8_t* frame, std::size_t size) noexcept;
  // A frame to the host; 0: none is left. Scans lost on the link are skipped.
  std::size_t NextFrame(std::uint8_t* frame, std::size_t capacity) noexcept;

  // Precondition: options.led.
  void SetAim(const HandAim& aim) noexcept { plant_.SetAim(aim); }

  // Shifts device time from now on (a suspended machine): the core sees its clock jump.
  void MoveClock(std::int64_t by_ns) noexcept { clock_offset_ns_ += by_ns; }

  // Advances 1 ms.
  void Tick() noexcept;

  std::int64_t now_ns() const noexcept { return plant_.now_ns(); }  // device time, 0 at start
  std::int64_t clock_offset_ns() const noexcept { return clock_offset_ns_; }
  std::uint64_t tick() const noexcept { return tick_; }
  TruthRow Truth() const noexcept;
  const Plant& plant() const noexcept { return plant_; }

 private:
  void Step() noexcept;
  void Peek(const std::uint8_t* frame, std::size_t size) noexcept;
  bool IsHeldUp(const std::uint8_t* frame, std::size_t size) noexcept;

  Plant plant_;
  firmware::FaultRecord record_;
  firmware::Core core_;
  firmware::Outputs outputs_;
  std::int64_t clock_offset_ns_;
  std::uint64_t tick_ = 0;
  HostView host_;  // for the recording
  std::int64_t command_ns_ = 0;
  float current_max_A_;
  // The link to the host.
  double scan_lost_, scan_late_;
  Random link_random_;
  std::array<std::uint8_t, wire::kFrameSizeMax> late_{};
  std::size_t late_size_ = 0;
  std::uint64_t late_tick_ = 0;
};

}  // namespace omni::sim
