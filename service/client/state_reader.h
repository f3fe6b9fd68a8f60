// Read-only view of omnid's state memory. No system call after construction; any number of threads may read.
// Whatever the memory holds, a read ends after a bounded number of steps and yields only samples in range
// (protocol/sample_range.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "service/base/result.h"
#include "service/base/sealed_memory.h"
#include "service/base/unique_fd.h"
#include "service/protocol/state_memory.h"

namespace omni::client {

class StateReader {
 public:
  // Checks seals (base::kSealsOneWriter), size, magic and version before anything is read. The error begins with "state
  // memory". Never null.
  static base::Result<std::shared_ptr<const StateReader>> Map(base::UniqueFd fd, std::uint32_t announced_bytes);
  StateReader(const StateReader&) = delete;
  StateReader& operator=(const StateReader&) = delete;

  std::uint64_t service_instance() const noexcept { return service_instance_; }

  // Newest published sample. False: nothing published yet, or torn kMaxTornReads times.
  bool ReadNewest(protocol::ToolSample& sample) const noexcept;

  // The sample that was published `back` samples before the newest; the oldest kept if there are not so many. False as
  // for ReadNewest.
  bool ReadEarlier(std::uint32_t back, protocol::ToolSample& sample) const noexcept;

  // The two samples around t_ns: before.t_ns <= t_ns <= after.t_ns. t_ns past the newest: both are the newest;
  // before the oldest kept: both are the oldest. False as for ReadNewest.
  bool ReadAround(std::int64_t t_ns, protocol::ToolSample& before, protocol::ToolSample& after) const noexcept;

  // The same of where a moving base is. False also if no base has moved yet.
  bool ReadNewest(protocol::BaseSample& sample) const noexcept;
  bool ReadAround(std::int64_t t_ns, protocol::BaseSample& before, protocol::BaseSample& after) const noexcept;

  // Publications so far; the newest is published() - 1.
  std::uint64_t published() const noexcept;

  // Of one publication. False: not published yet, overwritten (the newest kRingCapacity - 1 are kept), or out of range.
  bool ReadAt(std::uint64_t index, protocol::ToolSample& sample, protocol::TelemetrySample& telemetry) const noexcept;

  bool ReadInputs(protocol::InputSnapshot& inputs) const noexcept;

  // What the tip touches now. False as for ReadNewest.
  bool ReadContacts(protocol::ContactSnapshot& contacts) const noexcept;

  // The car of the active scene; `vehicle.on` says whether it has one. False as for ReadNewest.
  bool ReadVehicle(protocol::VehicleSnapshot& vehicle) const noexcept;

 private:
  explicit StateReader(base::Mapping mapping)
      : mapping_(std::move(mapping)),
        memory_(static_cast<const protocol::StateMemory*>(mapping_.get())),
        service_instance_(memory_->header.service_instance) {}
  // A block of its own. False: torn kMaxTornReads times, out of range, or never written.
  template <class Block, class Snapshot>
  static bool ReadBlock(const Block& block, Snapshot& snapshot) noexcept;

  base::Mapping mapping_;
  const protocol::StateMemory* memory_;
  std::uint64_t service_instance_;
};

}  // namespace omni::client
