// The device that forces and poses come from and go to, with its loop: which one there is, what is known of it, and
// what its tick may still hold. The main thread attaches and detaches it when a device comes and goes.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "service/base/threads/realtime_threads.h"
#include "service/config/files/calibration_file.h"
#include "service/device/transport.h"
#include "service/loop/tick_thread.h"
#include "service/protocol/force_feedback.h"
#include "service/room/room_finding.h"

namespace omni::daemon {

// Any thread: a mutex guards it all.
class AttachedDevice {
 public:
  struct State {
    loop::TickThread* loop = nullptr;  // null: no device
    const device::Transport* transport = nullptr;
    std::string absent_why = "not opened yet";
    // What forces the device that is attached, or about to be, can make. Detach resets it.
    protocol::ForceProperties force_properties;
    base::KeyStates keys;
    room::RoomField field;                  // about the base, of the newest second in which it is known
    config::CalibrationChoice calibration;  // of the device that is being opened; a new one resets what follows
    std::string misfit;                     // a magnet is near, but no pose explains the readings; empty: it is not so
    std::string starved;                    // this computer does not keep up with the base; empty: it does
    std::vector<room::RoomFinding> room;    // what is wrong with sensors or the room
  };
  explicit AttachedDevice(config::CalibrationChoice calibration) { state_.calibration = std::move(calibration); }

  // Both outlive the attachment. Detach stops the loop and returns when the service no longer uses either.
  void Attach(loop::TickThread& loop, const device::Transport& transport);
  void Detach(const std::string& why);
  // Takes the coils to zero while the process ends. Waits briefly for the loop.
  void CoilsToZero() noexcept;
  void SetCalibration(config::CalibrationChoice choice);
  void SetKeys(const base::KeyStates& keys);

  // Calls `use` with the state, under the mutex.
  template <class Use>
  auto With(Use use) {
    const std::lock_guard lock(mutex_);
    return use(state_);
  }
  // Calls `use` with the loop, which is not stopped meanwhile. False: there is none.
  template <class Use>
  bool WithLoop(Use use) {
    const std::lock_guard lock(mutex_);
    if (state_.loop != nullptr) use(*state_.loop);
    return state_.loop != nullptr;
  }

 private:
  base::PriorityMutex mutex_;
  State state_;
};

// What the tick is handed, one after the other, and what it may still hold: until it has taken the newest it may hold,
// or be about to take, any earlier one. A number is never reused, so an old acknowledgement cannot be taken for a new
// one. Control thread only.
template <class T>
class HandOver {
 public:
  using Pointer = std::shared_ptr<const T>;

  const Pointer& newest() const { return newest_; }  // null: the tick is to have none
  std::uint64_t number() const { return number_; }   // of the newest: counts
  // False: it is the newest already.
  bool Give(Pointer next) {
    if (next == newest_) return false;
    Retire(std::exchange(newest_, std::move(next)));
    ++number_;
    return true;
  }
  // Holds `old`, if it is one, until the tick has taken the newest.
  void Retire(Pointer old) {
    if (old != nullptr) retired_.push_back(std::move(old));
  }
  // Those that the tick has given up since. `taken`: the number that it has acknowledged; none: there is no tick.
  std::vector<Pointer> Release(std::optional<std::uint64_t> taken) {
    return taken.value_or(number_) == number_ ? std::exchange(retired_, {}) : std::vector<Pointer>{};
  }

 private:
  Pointer newest_;
  std::uint64_t number_ = 0;
  std::vector<Pointer> retired_;
};

// Clocks the loop by the arrival of a transport's telemetry.
class TransportTickSource : public loop::TickSource {
 public:
  // `transport` outlives this. patience_ns: how long Wait blocks before it returns kTimeout.
  explicit TransportTickSource(device::Transport& transport, std::int64_t patience_ns = 20'000'000)
      : transport_(transport), patience_ns_(patience_ns) {}

  loop::WaitStatus Wait(base::HallScan& scan) noexcept override {
    switch (transport_.Read(scan, patience_ns_)) {
      case device::ReadStatus::kScan:
        return loop::WaitStatus::kTick;
      case device::ReadStatus::kTimeout:
        return loop::WaitStatus::kTimeout;
      case device::ReadStatus::kEnd:
        return loop::WaitStatus::kEnd;
      case device::ReadStatus::kGone:
        break;
    }
    return loop::WaitStatus::kGone;
  }

  void Apply(const base::CoilCurrents& currents) noexcept override { transport_.Write(currents); }

 private:
  device::Transport& transport_;
  std::int64_t patience_ns_;
};

}  // namespace omni::daemon
