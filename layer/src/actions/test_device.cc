#include "layer/src/actions/test_device.h"

#include <sys/mman.h>

#include <new>
#include <stdexcept>

#include "service/base/clock.h"
#include "service/protocol/environment.h"
#include "service/protocol/state_memory.h"

namespace omni::layer {
namespace {

using protocol::StateMemory;

constexpr std::uint64_t kTestInstance = 1;  // no service's: those are random

}  // namespace

bool TestDevice::IsEnabled() { return protocol::EnvironmentVariable("OMNI_TEST_MODE") == "1"; }

TestDevice::TestDevice() {
  auto made =
      base::MakeSealedMemory("omni-test-pen", sizeof(StateMemory), PROT_READ | PROT_WRITE, base::kSealsOneWriter);
  if (!made.ok()) throw std::runtime_error(made.error());
  mapping_ = std::move(made->mapping);
  memory_ = new (mapping_.get()) StateMemory;
  memory_->header.total_bytes = sizeof(StateMemory);
  memory_->header.service_instance = kTestInstance;
  auto reader = client::StateReader::Map(std::move(made->fd), sizeof(StateMemory));
  if (!reader.ok()) throw std::runtime_error(reader.error());
  reader_ = std::move(*reader);
}

bool TestDevice::in_control() const {
  const std::lock_guard lock(mutex_);
  return in_control_;
}

TestInputs TestDevice::inputs() const {
  const std::lock_guard lock(mutex_);
  return inputs_;
}

void TestDevice::SetActive(const std::string& profile, bool active) {
  const std::lock_guard lock(mutex_);
  in_control_ = true;
  if (profile != inputs_.profile) inputs_.values.clear();
  inputs_.profile = profile;
  inputs_.active = active;
  Publish();
}

void TestDevice::SetValue(const std::string& path, float value) {
  const std::lock_guard lock(mutex_);
  in_control_ = true;
  InputValue& input = inputs_.values[path];
  if (input.value <= 0.5f && value > 0.5f) ++input.press_count;
  if (input.value > 0.5f && value <= 0.5f) ++input.release_count;
  if (input.value < value || input.value > value) input.t_change_ns = base::MonotonicNow_ns();
  input.value = value;
}

void TestDevice::SetPose(const Pose& X_BT) {
  const std::lock_guard lock(mutex_);
  in_control_ = true;
  X_BT_ = X_BT;
  Publish();
}

void TestDevice::RefreshSample() noexcept {
  const std::lock_guard lock(mutex_);
  if (in_control_) Publish();
}

void TestDevice::Publish() noexcept {
  protocol::ToolSample sample;
  sample.t_ns = base::MonotonicNow_ns();
  sample.flags = inputs_.active ? protocol::kToolPoseValid | protocol::kToolTracked | protocol::kToolAligned : 0u;
  sample.position_base_m = {X_BT_.p.x, X_BT_.p.y, X_BT_.p.z};
  sample.orientation_base_wxyz = {X_BT_.q.w, X_BT_.q.x, X_BT_.q.y, X_BT_.q.z};
  protocol::InputSnapshot none;
  none.t_ns = sample.t_ns;
  const std::uint64_t sequence = protocol::SequenceOf(published_);
  protocol::StoreCell(memory_->inputs, sequence, none);
  protocol::StoreCell(memory_->ring[published_ % protocol::kRingCapacity], sequence, sample);
  memory_->header.published.store(++published_, std::memory_order_release);
}

}  // namespace omni::layer
