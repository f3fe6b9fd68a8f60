// The reader against brute force, against a writer at full speed and against garbage.
#include "service/client/state_reader.h"
#include "service/base/sealed_memory.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <limits>
#include <new>
#include <random>
#include <thread>
#include <vector>

#include "service/ipc/state_publisher.h"
#include "service/protocol/sample_range.h"
#include "service/protocol/state_memory.h"
#include "tests/support/same_bits.h"

namespace omni {
namespace test_ipc_state_reader {

using client::StateReader;
using ipc::StatePublisher;
using protocol::StateMemory;
using protocol::ToolSample;
using support::SameBits;

constexpr std::size_t kKept = protocol::kRingCapacity - 1;

ToolSample SampleOf(std::int64_t t_ns) {
  ToolSample sample;
  const double x = static_cast<double>(t_ns % 100'000);
  sample.t_ns = t_ns;
  sample.position_base_m.fill(x);
  sample.orientation_base_wxyz.fill(x);
  sample.linear_velocity_base_m_s.fill(x + 1);
  sample.angular_velocity_base_rad_s.fill(x + 2);
  sample.force_base_N.fill(x + 3);
  sample.position_sigma_m = x + 4;
  sample.gap_m = x + 5;
  return sample;
}

// Telemetry of a publication is that of its own sample: whatever is kept can be read, and nothing else.
TEST(StateReaderTelemetry, AtReturnsEachKeptPublicationAndNoOther) {
  const auto publisher = std::move(StatePublisher::Create(1).value());
  const auto reader = StateReader::Map(base::UniqueFd(::dup(publisher->fd())), sizeof(StateMemory)).value();
  ToolSample sample;
  protocol::TelemetrySample telemetry;
  EXPECT_FALSE(reader->ReadAt(0, sample, telemetry));
  constexpr std::uint64_t kAll = 3 * protocol::kRingCapacity + 17;
  for (std::uint64_t i = 0; i < kAll; ++i) {
    protocol::TelemetrySample of_tick;
    of_tick.tick_ns = static_cast<std::uint32_t>(i);
    of_tick.current_A = {static_cast<float>(i), 1, 2};
    publisher->PublishTelemetry(of_tick);
    publisher->Publish(SampleOf(static_cast<std::int64_t>(1000 + i)), {});
  }
  EXPECT_EQ(reader->published(), kAll);
  for (std::uint64_t i = 0; i < kAll + 5; ++i) {
    const bool kept = i < kAll && i + protocol::kRingCapacity >= kAll;
    ASSERT_EQ(reader->ReadAt(i, sample, telemetry), kept) << i;
    if (!kept) continue;
    EXPECT_EQ(sample.t_ns, static_cast<std::int64_t>(1000 + i));
    EXPECT_EQ(telemetry.tick_ns, i);
    EXPECT_EQ(telemetry.current_A[0], static_cast<float>(i));
  }
}

// A tick without telemetry, as of another program's writer: there is none rather than that of 512 ticks ago.
TEST(StateReaderTelemetry, PublicationWithoutTelemetryHasNone) {
  const auto publisher = std::move(StatePublisher::Create(1).value());
  const auto reader = StateReader::Map(base::UniqueFd(::dup(publisher->fd())), sizeof(StateMemory)).value();
  ToolSample sample;
  protocol::TelemetrySample telemetry;
  publisher->PublishTelemetry({});
  publisher->Publish(SampleOf(1), {});
  publisher->Publish(SampleOf(2), {});
  EXPECT_TRUE(reader->ReadAt(0, sample, telemetry));
  EXPECT_FALSE(reader->ReadAt(1, sample, telemetry));
}

TEST(StateReaderProperty, AroundAgreesWithBruteForce) {
  std::mt19937_64 random(11);
  const auto publisher = std::move(StatePublisher::Create(1).value());
  const auto reader = StateReader::Map(base::UniqueFd(::dup(publisher->fd())), sizeof(StateMemory)).value();
  std::deque<std::int64_t> kept;
  std::int64_t t_ns = 1000;
  for (int i = 0; i < 3000; ++i) {
    t_ns += static_cast<std::int64_t>(random() % 4 == 0 ? 0 : random() % 2000);  // equal stamps and gaps happen
    publisher->Publish(SampleOf(t_ns), {});
    kept.push_back(t_ns);
    if (kept.size() > kKept) kept.pop_front();
    for (int question = 0; question < 8; ++question) {
      const std::int64_t span = kept.back() - kept.front() + 400;
      const std::int64_t asked =
          kept.front() - 200 + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(span));
      // The last stamp <= asked and the first > asked, or the ends.
      const auto next = std::upper_bound(kept.begin(), kept.end(), asked);
      const std::int64_t expect_after = next == kept.end() ? kept.back() : *next;
      const std::int64_t expect_before = next == kept.begin() ? kept.front()
                                         : next == kept.end() ? kept.back()
                                                              : *(next - 1);
      ToolSample before;
      ToolSample after;
      ASSERT_TRUE(reader->ReadAround(asked, before, after));
      ASSERT_EQ(before.t_ns, expect_before);
      ASSERT_EQ(after.t_ns, expect_after);
      ASSERT_TRUE(SameBits(before, SampleOf(before.t_ns)) && SameBits(after, SampleOf(after.t_ns)));
    }
  }
}

// Poses of a base have a ring and a count of their own.
TEST(StateReaderProperty, BasesAroundAgreesWithBruteForce) {
  std::mt19937_64 random(12);
  const auto publisher = std::move(StatePublisher::Create(1).value());
  const auto reader = StateReader::Map(base::UniqueFd(::dup(publisher->fd())), sizeof(StateMemory)).value();
  protocol::BaseSample before, after;
  publisher->Publish(SampleOf(1), {});
  EXPECT_FALSE(reader->ReadNewest(after) || reader->ReadAround(1, before, after)) << "no base has moved";
  std::deque<std::int64_t> kept;
  std::int64_t t_ns = 1000;
  for (int i = 0; i < 3000; ++i) {
    t_ns += static_cast<std::int64_t>(random() % 4 == 0 ? 0 : random() % 2000);
    protocol::BaseSample sample{.t_ns = t_ns, .position_space_m = {1e-3 * static_cast<double>(t_ns), 0, 0}};
    publisher->PublishBase(sample);
    kept.push_back(t_ns);
    if (kept.size() > protocol::kBaseRingCapacity - 1) kept.pop_front();
    ASSERT_TRUE(reader->ReadNewest(after));
    ASSERT_EQ(after.t_ns, t_ns);
    const std::int64_t asked =
        kept.front() - 200 +
        static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(kept.back() - kept.front() + 400));
    const auto next = std::upper_bound(kept.begin(), kept.end(), asked);
    ASSERT_TRUE(reader->ReadAround(asked, before, after));
    ASSERT_EQ(after.t_ns, next == kept.end() ? kept.back() : *next);
    ASSERT_EQ(before.t_ns, next == kept.begin() ? kept.front() : next == kept.end() ? kept.back() : *(next - 1));
    ASSERT_EQ(before.position_space_m[0], 1e-3 * static_cast<double>(before.t_ns));
  }
}

TEST(StateReaderProperty, NeverMixesSamplesUnderAFastWriter) {
  const auto publisher = std::move(StatePublisher::Create(1).value());
  const auto reader = StateReader::Map(base::UniqueFd(::dup(publisher->fd())), sizeof(StateMemory)).value();
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    for (std::int64_t t_ns = 1; !stop.load(std::memory_order_relaxed); ++t_ns) {
      protocol::InputSnapshot inputs;
      inputs.t_ns = t_ns;
      for (auto& component : inputs.components) component.t_change_ns = t_ns;
      publisher->Publish(SampleOf(t_ns), inputs);
    }
  });
  ToolSample first;
  while (!reader->ReadNewest(first)) std::this_thread::yield();
  std::mt19937_64 random(3);
  int pairs = 0;
  int newest_count = 0;
  std::int64_t last_ns = 0;
  for (int i = 0; i < 60'000; ++i) {
    ToolSample newest;
    if (!reader->ReadNewest(newest)) continue;
    ++newest_count;
    ASSERT_TRUE(SameBits(newest, SampleOf(newest.t_ns)));
    ASSERT_GE(newest.t_ns, last_ns);
    last_ns = newest.t_ns;
    ToolSample before;
    ToolSample after;
    const std::int64_t asked = newest.t_ns - static_cast<std::int64_t>(random() % 600);
    if (reader->ReadAround(asked, before, after)) {
      ++pairs;
      ASSERT_TRUE(SameBits(before, SampleOf(before.t_ns)) && SameBits(after, SampleOf(after.t_ns)));
      const bool around = before.t_ns <= asked && asked <= after.t_ns;
      ASSERT_TRUE(around || before.t_ns == after.t_ns);
      ASSERT_LE(after.t_ns - before.t_ns, 1);
    }
    protocol::InputSnapshot inputs;
    if (reader->ReadInputs(inputs)) {
      for (const auto& component : inputs.components) ASSERT_EQ(component.t_change_ns, inputs.t_ns);
    }
  }
  stop = true;
  writer.join();
  EXPECT_GT(newest_count, 0);
  EXPECT_GT(pairs, 0);
}

// State memory that the test can write as it likes, behind a reader that accepted it.
struct HostileMemory {
  HostileMemory() {
    const int fd = ::memfd_create("hostile", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    EXPECT_EQ(::ftruncate(fd, sizeof(StateMemory)), 0);
    void* mapped = ::mmap(nullptr, sizeof(StateMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    EXPECT_NE(mapped, MAP_FAILED);
    memory = new (mapped) StateMemory;
    memory->header.total_bytes = sizeof(StateMemory);
    EXPECT_EQ(::fcntl(fd, F_ADD_SEALS, base::kSealsOneWriter), 0);
    reader = StateReader::Map(base::UniqueFd(fd), sizeof(StateMemory)).value();
  }
  HostileMemory(const HostileMemory&) = delete;
  HostileMemory& operator=(const HostileMemory&) = delete;
  ~HostileMemory() { ::munmap(memory, sizeof(StateMemory)); }
  StateMemory* memory = nullptr;
  std::shared_ptr<const StateReader> reader;
};

// Whatever the memory holds: reads end, and yield only values in range.
void ReadAll(const StateReader& reader, std::mt19937_64& random) {
  ToolSample a;
  ToolSample b;
  protocol::InputSnapshot inputs;
  if (reader.ReadNewest(a)) {
    EXPECT_TRUE(protocol::InRange(a));
  }
  if (reader.ReadInputs(inputs)) {
    EXPECT_TRUE(protocol::InRange(inputs));
  }
  protocol::ContactSnapshot contacts;
  if (reader.ReadContacts(contacts)) {
    EXPECT_TRUE(protocol::InRange(contacts));
  }
  protocol::VehicleSnapshot car;
  if (reader.ReadVehicle(car)) {
    EXPECT_TRUE(protocol::InRange(car));
  }
  const std::int64_t asked[] = {0, std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(),
                                static_cast<std::int64_t>(random()), static_cast<std::int64_t>(random() % 1'000'000)};
  for (const std::int64_t t_ns : asked) {
    if (!reader.ReadAround(t_ns, a, b)) continue;
    EXPECT_TRUE(protocol::InRange(a) && protocol::InRange(b));
    EXPECT_LE(a.t_ns, b.t_ns);
  }
}

TEST(StateReaderProperty, RandomMemoryYieldsOnlyValuesInRange) {
  std::mt19937_64 random(5);
  const HostileMemory hostile;
  ASSERT_NE(hostile.reader, nullptr);
  for (int round = 0; round < 300; ++round) {
    hostile.memory->header.published = round % 3 == 0 ? random() : random() % 2000;
    for (auto& slot : hostile.memory->ring) {
      slot.sequence = random();
      for (auto& word : slot.words) word = random();
    }
    const auto fill = [&random](auto& block) {
      block.sequence = random() & ~std::uint64_t{1};
      for (auto& word : block.words) word = random();
    };
    fill(hostile.memory->inputs);
    fill(hostile.memory->contacts);
    fill(hostile.memory->vehicle);
    ReadAll(*hostile.reader, random);
  }
}

// Sequences are right, so that the search runs on garbage times and values.
TEST(StateReaderProperty, GarbageWithValidSequencesYieldsOnlyValuesInRange) {
  std::mt19937_64 random(6);
  const HostileMemory hostile;
  ASSERT_NE(hostile.reader, nullptr);
  for (int round = 0; round < 300; ++round) {
    const std::uint64_t published = round % 2 == 0 ? 1 + random() % 3000 : random();
    hostile.memory->header.published = published;
    for (std::uint64_t back = 1; back <= std::min<std::uint64_t>(published, protocol::kRingCapacity); ++back) {
      const std::uint64_t index = published - back;
      ToolSample sample = SampleOf(static_cast<std::int64_t>(random() % 1'000'000));
      if (random() % 20 == 0) sample.gap_m = std::numeric_limits<double>::quiet_NaN();
      if (random() % 20 == 0) sample.t_ns = static_cast<std::int64_t>(random());
      protocol::StoreCell(hostile.memory->ring[index % protocol::kRingCapacity], protocol::SequenceOf(index), sample);
    }
    ReadAll(*hostile.reader, random);
  }
}

TEST(StateReaderProperty, ExtremePublicationCountsReadAsNothing) {
  std::mt19937_64 random(8);
  const HostileMemory hostile;
  ASSERT_NE(hostile.reader, nullptr);
  for (const std::uint64_t published : {std::uint64_t{1} << 63, (std::uint64_t{1} << 63) + 1, ~std::uint64_t{0},
                                        std::uint64_t{1} << 62, std::uint64_t{0}}) {
    hostile.memory->header.published = published;
    ReadAll(*hostile.reader, random);
    ToolSample sample;
    EXPECT_FALSE(hostile.reader->ReadNewest(sample));
  }
}

}  // namespace test_ipc_state_reader
}  // namespace omni
