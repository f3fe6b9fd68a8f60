// The whole loop in virtual time over a transport: called by `omni twin run`, the benchmarks and the scenarios of the
// tests.
#pragma once

#include <cstdint>
#include <functional>

#include "service/device/transport.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick.h"

namespace omni::daemon {

struct VirtualRunSummary {
  std::uint64_t ticks = 0;
  std::uint64_t tracked_ticks = 0;
  std::uint64_t contact_ticks = 0;  // rendered force over 10 mN
  std::uint64_t select_presses = 0;
  double peak_force_N = 0;
  std::uint64_t hash = 0;  // over the bits of every tick's scan, state, wrench and currents
};

// Called before each tick: the clients' commands. Default: the gate is open, always.
using CommandScript = std::function<loop::Commands(const base::HallScan&)>;
using TickObserver = std::function<void(const base::HallScan&, const loop::TickOutput&)>;

// Runs until the transport returns kEnd or kGone. `scene` becomes generation 1; sculptable objects are edited every 2
// ms of virtual time and stay as they are left.
VirtualRunSummary RunVirtual(const loop::TickConfig& config, device::Transport& transport, const haptics::Scene& scene,
                             const CommandScript& script = {}, const TickObserver& observer = {});

// FNV-1a, 64 bit, over the values' bytes (never over padding).
class TickHash {
 public:
  void Add(const base::HallScan& scan, const loop::TickOutput& output) noexcept;
  std::uint64_t value() const noexcept { return hash_; }

 private:
  template <class T>
  void Bits(const T& value) noexcept;
  void Vector(const base::Vec3& v) noexcept;
  std::uint64_t hash_ = 14695981039346656037ULL;
};

}  // namespace omni::daemon
