#include "service/ipc/state_publisher.h"

#include <sys/mman.h>

#include <algorithm>
#include <new>
#include <utility>

#include "service/protocol/sample_range.h"
#include "service/protocol/state_memory.h"

namespace omni::ipc {

using protocol::StateMemory;

base::Result<std::unique_ptr<StatePublisher>> StatePublisher::Create(std::uint64_t service_instance) {
  auto made = base::MakeSealedMemory("omni-state", sizeof(StateMemory), PROT_READ | PROT_WRITE, base::kSealsOneWriter);
  if (!made) return base::Error{made.error()};
  auto* memory = new (made->mapping.get()) StateMemory;
  memory->header.total_bytes = sizeof(StateMemory);
  memory->header.service_instance = service_instance;
  return std::unique_ptr<StatePublisher>(new StatePublisher(std::move(*made), memory));
}

void StatePublisher::Publish(const protocol::ToolSample& sample, const protocol::InputSnapshot& inputs) noexcept {
  const std::uint64_t sequence = protocol::SequenceOf(published_);
  protocol::ToolSample sane = protocol::Clamped(sample);
  newest_t_ns_ = sane.t_ns = std::max(newest_t_ns_, sane.t_ns);
  protocol::StoreCell(memory_->inputs, sequence, protocol::Clamped(inputs));
  protocol::StoreCell(memory_->ring[published_ % protocol::kRingCapacity], sequence, sane);
  ++published_;
  memory_->header.published.store(published_, std::memory_order_release);
}

void StatePublisher::PublishTelemetry(const protocol::TelemetrySample& telemetry) noexcept {
  protocol::StoreCell(memory_->telemetry[published_ % protocol::kRingCapacity], protocol::SequenceOf(published_),
                      protocol::Clamped(telemetry));
}

void StatePublisher::PublishBase(const protocol::BaseSample& sample) noexcept {
  protocol::StoreCell(memory_->bases[bases_published_ % protocol::kBaseRingCapacity],
                      protocol::SequenceOf(bases_published_), sample);
  ++bases_published_;
  memory_->header.bases_published.store(bases_published_, std::memory_order_release);
}

void StatePublisher::PublishContacts(const protocol::ContactSnapshot& contacts) noexcept {
  const bool as_before = contacts.count == 0 && contact_count_ == 0 && contact_generation_ == contacts.scene_generation;
  if (as_before && contacts_published_ > 0) return;
  contact_count_ = contacts.count;
  contact_generation_ = contacts.scene_generation;
  protocol::StoreCell(memory_->contacts, protocol::SequenceOf(contacts_published_++), protocol::Clamped(contacts));
}

void StatePublisher::PublishVehicle(const protocol::VehicleSnapshot& vehicle) noexcept {
  const bool was_on = vehicle_on_;
  vehicle_on_ = vehicle.on != 0;
  if (!vehicle_on_ && !was_on && vehicles_published_ > 0) return;
  protocol::StoreCell(memory_->vehicle, protocol::SequenceOf(vehicles_published_++), protocol::Clamped(vehicle));
}

}  // namespace omni::ipc
