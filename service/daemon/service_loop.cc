// What other threads than the control thread call: the device's thread, that of the keys, that of the surfaces.
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

#include "service/base/clock.h"
#include "service/daemon/service.h"

namespace omni::daemon {
namespace {

constexpr int kZeroWait_ms = 30;  // for the loop; a base is at zero 20 ms after the last command anyway

}  // namespace

void Service::Attach(loop::TickThread& loop, const device::Transport& transport) {
  const std::lock_guard lock(loop_mutex_);
  loop_ = &loop;
  transport_ = &transport;
  loop.keys().Write(key_states_);
}

double Service::Idle_s() const { return 1e-9 * static_cast<double>(base::MonotonicNow_ns() - busy_ns_.load()); }

void Service::SetKeys(const base::KeyStates& keys) {
  const std::lock_guard lock(loop_mutex_);
  key_states_ = keys;
  if (loop_ != nullptr) loop_->keys().Write(keys);
}

void Service::Detach(const std::string& why) {
  loop::TickThread* loop = nullptr;
  {
    const std::lock_guard lock(loop_mutex_);
    loop = loop_;
  }
  if (loop != nullptr) loop->Stop();  // before its scenes may be freed
  const std::lock_guard lock(loop_mutex_);
  loop_ = nullptr;
  transport_ = nullptr;
  force_properties_ = {};
  device_absent_why_ = why;
}

void Service::CoilsToZero() noexcept {
  const auto nap = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
  std::unique_lock<std::mutex> lock(loop_mutex_, std::defer_lock);
  for (int ms = 0; ms < kZeroWait_ms && !lock.try_lock(); ++ms) nap();
  if (!lock.owns_lock() || loop_ == nullptr) return;
  loop_->RequestStop();
  for (int ms = 0; ms < kZeroWait_ms && !loop_->finished(); ++ms) nap();
}

void Service::SetCalibration(config::CalibrationChoice choice) {
  const std::lock_guard lock(loop_mutex_);
  calibration_ = std::move(choice);
  misfit_.clear();
  starved_.clear();
  room_.clear();
}

void Service::SetMisfit(std::string misfit) {
  const std::lock_guard lock(loop_mutex_);
  misfit_ = std::move(misfit);
}

void Service::SetStarved(std::string starved) {
  const std::lock_guard lock(loop_mutex_);
  starved_ = std::move(starved);
}

void Service::SetRoom(std::vector<room::RoomFinding> findings) {
  const std::lock_guard lock(loop_mutex_);
  room_ = std::move(findings);
}

void Service::SetField(const room::RoomField& field) {
  const std::lock_guard lock(loop_mutex_);
  field_ = field;
}

void Service::SetForceProperties(const protocol::ForceProperties& properties) {
  const std::lock_guard lock(loop_mutex_);
  force_properties_ = properties;
}

bool Service::ReadSnapshot(loop::SurfaceSnapshot& snapshot) {
  const std::lock_guard lock(loop_mutex_);
  if (loop_ == nullptr) return false;
  snapshot = loop_->surfaces().Read();
  return true;
}

}  // namespace omni::daemon
