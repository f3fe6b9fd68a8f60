#include "service/daemon/devices/attached_device.h"

#include <chrono>
#include <thread>

namespace omni::daemon {
namespace {

constexpr int kZeroWait_ms = 30;  // for the loop; a base is at zero 20 ms after the last command anyway

}  // namespace

void AttachedDevice::Attach(loop::TickThread& loop, const device::Transport& transport) {
  const std::lock_guard lock(mutex_);
  state_.loop = &loop;
  state_.transport = &transport;
  loop.keys().Write(state_.keys);
}

void AttachedDevice::Detach(const std::string& why) {
  loop::TickThread* loop = With([](const State& state) { return state.loop; });
  if (loop != nullptr) loop->Stop();  // before its scenes may be freed
  const std::lock_guard lock(mutex_);
  state_.loop = nullptr;
  state_.transport = nullptr;
  state_.force_properties = {};
  state_.absent_why = why;
}

void AttachedDevice::CoilsToZero() noexcept {
  const auto nap = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
  std::unique_lock<std::mutex> lock(mutex_, std::defer_lock);
  for (int ms = 0; ms < kZeroWait_ms && !lock.try_lock(); ++ms) nap();
  if (!lock.owns_lock() || state_.loop == nullptr) return;
  state_.loop->RequestStop();
  for (int ms = 0; ms < kZeroWait_ms && !state_.loop->finished(); ++ms) nap();
}

void AttachedDevice::SetCalibration(config::CalibrationChoice choice) {
  const std::lock_guard lock(mutex_);
  state_.calibration = std::move(choice);
  state_.misfit.clear();
  state_.starved.clear();
  state_.room.clear();
}

void AttachedDevice::SetKeys(const base::KeyStates& keys) {
  const std::lock_guard lock(mutex_);
  state_.keys = keys;
  if (state_.loop != nullptr) state_.loop->keys().Write(keys);
}

}  // namespace omni::daemon
