#include "service/client/state_reader.h"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "service/protocol/sample_range.h"
#include "service/protocol/state_memory.h"

namespace omni::client {
namespace {

using protocol::BaseSample;
using protocol::kRingCapacity;
using protocol::StateHeader;
using protocol::StateMemory;
using protocol::ToolSample;

// Written once, before the service shares the memory.
std::string HeaderProblem(const StateHeader& header) {
  const StateHeader mine;
  if (header.magic != mine.magic) return "does not begin with the state memory's magic";
  if (header.version != protocol::kStateVersion) {
    return "has layout version " + std::to_string(header.version) + ", this client knows " +
           std::to_string(protocol::kStateVersion) + "; install the same Omni version for service and layer";
  }
  const bool same_layout = header.total_bytes == sizeof(StateMemory) && header.ring_capacity == mine.ring_capacity &&
                           header.slot_bytes == mine.slot_bytes && header.input_bytes == mine.input_bytes &&
                           header.contact_bytes == mine.contact_bytes && header.vehicle_bytes == mine.vehicle_bytes &&
                           header.telemetry_bytes == mine.telemetry_bytes && header.base_bytes == mine.base_bytes;
  return same_layout ? std::string()
                     : "has a different layout than this client was built for; install the same Omni version for both";
}

// A ring of samples and the number published in it. One attempt each; false: torn, overwritten, or out of range.
template <class Sample, std::size_t kCapacity>
class Ring {
 public:
  Ring(const std::array<protocol::SeqlockCell<Sample>, kCapacity>& slots, const protocol::Word& published) noexcept
      : slots_(slots), published_(published) {}

  // 0: nothing yet, or a number that no writer reaches (its sequences would wrap around).
  std::uint64_t Published() const noexcept {
    const std::uint64_t published = published_.load(std::memory_order_acquire);
    return published <= std::uint64_t{1} << 62 ? published : 0;
  }
  // How many of so many are kept. The slot of publication `published - kCapacity` is the one that the writer may be in.
  static std::uint64_t Kept(std::uint64_t published) noexcept {
    return std::min<std::uint64_t>(published, kCapacity - 1);
  }
  bool Read(std::uint64_t index, Sample& sample) const noexcept;
  bool Newest(Sample& sample) const noexcept;
  bool Around(std::int64_t t_ns, Sample& before, Sample& after) const noexcept;

 private:
  bool ReadTime(std::uint64_t index, std::int64_t& t_ns) const noexcept;
  bool TryAround(std::int64_t t_ns, Sample& before, Sample& after) const noexcept;

  const std::array<protocol::SeqlockCell<Sample>, kCapacity>& slots_;
  const protocol::Word& published_;
};

template <class Sample, std::size_t kCapacity>
bool Ring<Sample, kCapacity>::Read(std::uint64_t index, Sample& sample) const noexcept {
  Sample copy;
  if (protocol::LoadCell(slots_[index % kCapacity], copy) != protocol::SequenceOf(index)) return false;
  if (!protocol::InRange(copy)) return false;
  sample = copy;
  return true;
}

template <class Sample, std::size_t kCapacity>
bool Ring<Sample, kCapacity>::ReadTime(std::uint64_t index, std::int64_t& t_ns) const noexcept {
  static_assert(offsetof(Sample, t_ns) == 0);
  const protocol::SeqlockCell<Sample>& slot = slots_[index % kCapacity];
  if (slot.sequence.load(std::memory_order_acquire) != protocol::SequenceOf(index)) return false;
  t_ns = static_cast<std::int64_t>(slot.words[0].load(std::memory_order_acquire));
  return slot.sequence.load(std::memory_order_acquire) == protocol::SequenceOf(index);
}

template <class Sample, std::size_t kCapacity>
bool Ring<Sample, kCapacity>::Newest(Sample& sample) const noexcept {
  for (int attempt = 0; attempt < protocol::kMaxTornReads; ++attempt) {
    const std::uint64_t published = Published();
    if (published == 0) return false;
    if (Read(published - 1, sample)) return true;
  }
  return false;
}

template <class Sample, std::size_t kCapacity>
bool Ring<Sample, kCapacity>::Around(std::int64_t t_ns, Sample& before, Sample& after) const noexcept {
  for (int attempt = 0; attempt < protocol::kMaxTornReads; ++attempt) {
    if (TryAround(t_ns, before, after)) return true;
  }
  return false;
}

// Times do not decrease with the index. Most reads are about the last few milliseconds, so the search gallops
// back from the newest (by 1, 2, 4, ... slots), then bisects: at most 2 log2(kCapacity) reads of a time stamp.
template <class Sample, std::size_t kCapacity>
bool Ring<Sample, kCapacity>::TryAround(std::int64_t t_ns, Sample& before, Sample& after) const noexcept {
  const std::uint64_t published = Published();
  if (published == 0) return false;
  const std::uint64_t newest = published - 1;
  const std::uint64_t oldest = published - Kept(published);

  // Invariant: time(low) <= t_ns < time(high).
  Sample newest_sample;
  if (!Read(newest, newest_sample)) return false;
  if (newest_sample.t_ns <= t_ns) {
    before = after = newest_sample;
    return true;
  }
  std::uint64_t high = newest;
  std::uint64_t low = newest;
  for (std::uint64_t stride = 1;; stride *= 2) {
    low -= std::min(stride, low - oldest);
    std::int64_t t_low_ns = 0;
    if (!ReadTime(low, t_low_ns)) return false;
    if (t_low_ns <= t_ns) break;
    high = low;
    if (low == oldest) {
      if (!Read(oldest, before)) return false;
      after = before;
      return true;
    }
  }
  while (high - low > 1) {
    const std::uint64_t middle = low + (high - low) / 2;
    std::int64_t t_middle_ns = 0;
    if (!ReadTime(middle, t_middle_ns)) return false;
    (t_middle_ns <= t_ns ? low : high) = middle;
  }
  // Memory that breaks the order of times (no writer of ours does) fails the last test.
  return Read(low, before) && Read(high, after) && before.t_ns <= t_ns && t_ns <= after.t_ns;
}

Ring<ToolSample, kRingCapacity> ToolRing(const StateMemory& memory) noexcept {
  return {memory.ring, memory.header.published};
}

Ring<BaseSample, protocol::kBaseRingCapacity> BaseRing(const StateMemory& memory) noexcept {
  return {memory.bases, memory.header.bases_published};
}

}  // namespace

base::Result<std::shared_ptr<const StateReader>> StateReader::Map(base::UniqueFd fd, std::uint32_t announced_bytes) {
  const auto refuse = [](const std::string& problem) { return base::Error{"state memory " + problem}; };
  if (announced_bytes != sizeof(StateMemory)) {
    return refuse("of " + std::to_string(announced_bytes) + " bytes was announced, must be " +
                  std::to_string(sizeof(StateMemory)));
  }
  auto mapping = base::MapSealed(fd.get(), base::kSealsOneWriter, sizeof(StateMemory), PROT_READ);
  if (!mapping.ok()) return refuse(mapping.error());
  std::shared_ptr<const StateReader> reader(new StateReader(std::move(*mapping)));
  const std::string problem = HeaderProblem(reader->memory_->header);
  if (!problem.empty()) return refuse(problem);
  return reader;
}

bool StateReader::ReadNewest(ToolSample& sample) const noexcept { return ToolRing(*memory_).Newest(sample); }

bool StateReader::ReadNewest(BaseSample& sample) const noexcept { return BaseRing(*memory_).Newest(sample); }

bool StateReader::ReadEarlier(std::uint32_t back, ToolSample& sample) const noexcept {
  const auto ring = ToolRing(*memory_);
  for (int attempt = 0; attempt < protocol::kMaxTornReads; ++attempt) {
    const std::uint64_t published = ring.Published();
    if (published == 0) return false;
    if (ring.Read(published - 1 - std::min<std::uint64_t>(back, ring.Kept(published) - 1), sample)) return true;
  }
  return false;
}

std::uint64_t StateReader::published() const noexcept { return ToolRing(*memory_).Published(); }

bool StateReader::ReadAt(std::uint64_t index, ToolSample& sample, protocol::TelemetrySample& telemetry) const noexcept {
  protocol::TelemetrySample copy;
  const auto ring = ToolRing(*memory_);
  if (index >= ring.Published() || !ring.Read(index, sample)) return false;
  if (protocol::LoadCell(memory_->telemetry[index % kRingCapacity], copy) != protocol::SequenceOf(index)) return false;
  if (!protocol::InRange(copy)) return false;
  telemetry = copy;
  return true;
}

template <class Block, class Snapshot>
bool StateReader::ReadBlock(const Block& block, Snapshot& snapshot) noexcept {
  for (int attempt = 0; attempt < protocol::kMaxTornReads; ++attempt) {
    Snapshot copy;
    if (protocol::LoadCell(block, copy) == 0 || !protocol::InRange(copy)) continue;
    snapshot = copy;
    return true;
  }
  return false;
}

bool StateReader::ReadInputs(protocol::InputSnapshot& inputs) const noexcept {
  return ReadBlock(memory_->inputs, inputs);
}

bool StateReader::ReadContacts(protocol::ContactSnapshot& contacts) const noexcept {
  return ReadBlock(memory_->contacts, contacts);
}

bool StateReader::ReadVehicle(protocol::VehicleSnapshot& vehicle) const noexcept {
  return ReadBlock(memory_->vehicle, vehicle);
}

bool StateReader::ReadAround(std::int64_t t_ns, ToolSample& before, ToolSample& after) const noexcept {
  return ToolRing(*memory_).Around(t_ns, before, after);
}

bool StateReader::ReadAround(std::int64_t t_ns, BaseSample& before, BaseSample& after) const noexcept {
  return BaseRing(*memory_).Around(t_ns, before, after);
}

}  // namespace omni::client
