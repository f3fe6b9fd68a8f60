// Writer of the state memory. Created by the control thread, written by the tick thread (base samples: by the control
// thread): plain atomic stores, no system call, no allocation, no lock.
#pragma once

#include <cstdint>
#include <memory>

#include "service/base/result.h"
#include "service/base/sealed_memory.h"
#include "service/protocol/state_memory.h"

namespace omni::ipc {

class StatePublisher {
 public:
  // Makes the memfd, maps it for writing, then seals it FUTURE_WRITE | SHRINK | GROW | SEAL.
  static base::Result<std::unique_ptr<StatePublisher>> Create(std::uint64_t service_instance);
  ~StatePublisher() = default;
  StatePublisher(const StatePublisher&) = delete;
  StatePublisher& operator=(const StatePublisher&) = delete;

  // Tick thread only. Times must not decrease from one call to the next: an older sample is published with the time of
  // the one before. An invalid sample is published as "no pose" (protocol/sample_range.h).
  void Publish(const protocol::ToolSample& sample, const protocol::InputSnapshot& inputs) noexcept;

  // Tick thread only, before Publish of the same scan. Writes only when something changes: contacts, their end, or the
  // scene. Contacts that are out of range are omitted.
  void PublishContacts(const protocol::ContactSnapshot& contacts) noexcept;

  // Tick thread only, before Publish of the same scan. Numbers that are out of range are clamped.
  void PublishTelemetry(const protocol::TelemetrySample& telemetry) noexcept;

  // As contacts, while the scene has a car, and once when it no longer has one. One that is out of range is published
  // as none.
  void PublishVehicle(const protocol::VehicleSnapshot& vehicle) noexcept;

  // Control thread only: where a base that moves is. In range, and not older than the one before.
  void PublishBase(const protocol::BaseSample& sample) noexcept;

  int fd() const { return memory_file_.fd.get(); }                 // to be passed to clients; stays ours
  std::uint64_t published() const noexcept { return published_; }  // tick thread only

 private:
  StatePublisher(base::SealedMemory memory_file, protocol::StateMemory* memory)
      : memory_file_(std::move(memory_file)), memory_(memory) {}
  base::SealedMemory memory_file_;
  protocol::StateMemory* memory_;
  std::uint64_t published_ = 0;
  std::int64_t newest_t_ns_ = 0;
  std::uint64_t contacts_published_ = 0;
  std::uint32_t contact_count_ = 0;
  std::uint64_t contact_generation_ = 0;
  std::uint64_t vehicles_published_ = 0;
  bool vehicle_on_ = false;
  std::uint64_t bases_published_ = 0;  // control thread only
};

}  // namespace omni::ipc
