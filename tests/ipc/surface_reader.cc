// The surface reader against a writer at full speed and against garbage.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <random>
#include <thread>

#include "service/base/sealed_memory.h"
#include "service/client/surface_reader.h"
#include "service/ipc/surface_publisher.h"
#include "service/protocol/state_memory.h"
#include "service/protocol/surfaces/surface_layout.h"

namespace omni {
namespace test_ipc_surface_reader {

using client::SurfaceCopy;
using client::SurfaceRead;
using client::SurfaceReader;
using ipc::SurfacePublisher;
using protocol::SurfacePoint;
using protocol::SurfaceTriangle;

const protocol::SurfacePlan kClay{.name = "clay",
                                  .flags = protocol::kSurfaceSculpted,
                                  .vertex_capacity = 3001,
                                  .triangle_capacity = 4001,
                                  .triangles_change = true};
const protocol::SurfacePlan kCup{.name = "cup", .object = 1, .flags = protocol::kSurfaceMoved};

// Every number of generation g says g.
struct Generation {
  std::vector<SurfacePoint> points;
  std::vector<SurfaceTriangle> triangles;
};
Generation MakeGeneration(std::uint32_t g) {
  const auto x = static_cast<float>(g % 50);
  const std::size_t vertices = 2000 + g % 1001, corners = 1000 + g % 3001;
  return {.points = std::vector<SurfacePoint>(vertices, SurfacePoint{x, x, x}),
          .triangles = std::vector<SurfaceTriangle>(corners, SurfaceTriangle{g % 1000, g % 1000, g % 1000})};
}

void ExpectOneGeneration(const SurfaceCopy& copy) {
  const auto g = static_cast<std::uint32_t>(copy.frame.t_ns);
  const Generation expected = MakeGeneration(g);
  ASSERT_EQ(copy.vertices_base_m, expected.points);
  ASSERT_EQ(copy.triangles, expected.triangles);
}

TEST(SurfaceReaderProperty, NeverMixesPublicationsUnderAFastWriter) {
  const protocol::SurfacePlan plans[] = {kClay, kCup};
  const auto publisher = std::move(SurfacePublisher::Create({.memory_generation = 1}, plans).value());
  const auto reader = SurfaceReader::Map(base::UniqueFd(::dup(publisher->fd())), publisher->bytes()).value();
  std::atomic<bool> stop{false};
  std::atomic<int> refused{0};
  std::thread writer([&] {
    for (std::uint32_t g = 1; !stop.load(std::memory_order_relaxed); ++g) {
      const Generation made = MakeGeneration(g);
      const auto done = publisher->Publish(0, {.t_ns = g, .vertices_base_m = made.points, .triangles = made.triangles});
      refused += done != ipc::SurfacePublish::kDone;
      publisher->PublishPulse(g);
    }
  });
  SurfaceCopy copy;
  int whole = 0;
  std::int64_t last_ns = 0;
  for (int i = 0; i < 200'000 && whole < 2000; ++i) {
    const SurfaceRead read = reader->Read(0, copy);
    if (read == SurfaceRead::kNothing || read == SurfaceRead::kUnchanged) continue;
    ++whole;
    ExpectOneGeneration(copy);
    if (HasFatalFailure()) break;
    EXPECT_GT(copy.frame.t_ns, last_ns);
    last_ns = copy.frame.t_ns;
  }
  stop = true;
  writer.join();
  EXPECT_EQ(refused, 0);
  EXPECT_GT(whole, 0);
  // And once the writer rests, the newest one is read.
  reader->Read(0, copy);
  EXPECT_EQ(reader->Read(0, copy), SurfaceRead::kUnchanged);
  ExpectOneGeneration(copy);
}

// Surface memory that the test can write as it likes, behind a reader that accepted it.
struct HostileSurfaces {
  HostileSurfaces() {
    const protocol::SurfacePlan plans[] = {kClay, kCup};
    const auto model = std::move(SurfacePublisher::Create({.memory_generation = 1}, plans).value());
    bytes = model->bytes();
    const int fd = ::memfd_create("hostile", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    EXPECT_EQ(::ftruncate(fd, static_cast<off_t>(bytes)), 0);
    void* mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    EXPECT_NE(mapped, MAP_FAILED);
    memory = static_cast<std::byte*>(mapped);
    EXPECT_EQ(::pread(model->fd(), memory, bytes, 0), static_cast<ssize_t>(bytes));
    EXPECT_EQ(::fcntl(fd, F_ADD_SEALS, base::kSealsOneWriter), 0);
    reader = SurfaceReader::Map(base::UniqueFd(fd), bytes).value();
  }
  HostileSurfaces(const HostileSurfaces&) = delete;
  HostileSurfaces& operator=(const HostileSurfaces&) = delete;
  ~HostileSurfaces() { ::munmap(memory, bytes); }

  protocol::SurfaceEntry& Entry(std::size_t i) const {
    return *reinterpret_cast<protocol::SurfaceEntry*>(memory + protocol::kSurfaceEntries +
                                                      i * sizeof(protocol::SurfaceEntry));
  }
  std::uint64_t bytes = 0;
  std::byte* memory = nullptr;
  std::shared_ptr<const SurfaceReader> reader;
};

void ExpectDrawable(const SurfaceReader& reader, std::size_t object, SurfaceCopy& copy) {
  if (reader.Read(object, copy) == SurfaceRead::kNothing) return;
  const protocol::SurfacePart& part = reader.object(object);
  ASSERT_LE(copy.vertices_base_m.size(), part.vertex_capacity);
  ASSERT_LE(copy.triangles.size(), part.triangle_capacity);
  ASSERT_TRUE(protocol::InRange(copy.frame));
  ASSERT_TRUE(protocol::InRange(copy.vertices_base_m));
  ASSERT_TRUE(protocol::InRange(copy.triangles, static_cast<std::uint32_t>(copy.vertices_base_m.size())));
}

// The writer has reused the buffer that was copied: three publications later, not two.
TEST(SurfaceReaderProperty, GivesUpReadsThatTheWriterOvertook) {
  const HostileSurfaces hostile;
  ASSERT_NE(hostile.reader, nullptr);
  protocol::SurfaceEntry& entry = hostile.Entry(0);
  constexpr std::uint64_t kChange = 10;
  protocol::StoreCell(entry.frame, protocol::SequenceOf(0),
                      {.vertex_change = kChange, .triangle_change = kChange, .vertex_count = 5, .triangle_count = 5});
  for (const std::uint64_t ahead : {0, 1, 2, 3, 4, 1000}) {
    for (protocol::Word* begun : {&entry.vertices_begun, &entry.triangles_begun}) {
      entry.vertices_begun = entry.triangles_begun = kChange;
      *begun = kChange + ahead;
      SurfaceCopy copy;
      EXPECT_EQ(hostile.reader->Read(0, copy) == SurfaceRead::kNothing, ahead >= 3) << ahead;
    }
  }
  entry.vertices_begun = kChange - 1;  // no writer of ours
  SurfaceCopy copy;
  EXPECT_EQ(hostile.reader->Read(0, copy), SurfaceRead::kNothing);
}

TEST(SurfaceReaderProperty, RandomMemoryYieldsOnlyDrawableSurfaces) {
  std::mt19937_64 random(3);
  const HostileSurfaces hostile;
  ASSERT_NE(hostile.reader, nullptr);
  SurfaceCopy copies[2];
  for (int round = 0; round < 300; ++round) {
    // Header, entries and buffers alike, over and over.
    for (std::size_t at = 0; at + 8 <= hostile.bytes; at += 8) {
      const std::uint64_t value = random() >> (random() % 64);
      std::memcpy(hostile.memory + at, &value, sizeof(value));
    }
    for (std::size_t object = 0; object < 2; ++object) ExpectDrawable(*hostile.reader, object, copies[object]);
    protocol::SurfacePulse pulse;
    (void)hostile.reader->ReadPulse(pulse);
    if (HasFatalFailure()) FAIL() << "round " << round;
  }
}

// Frames that look right over buffers that are not, and the reverse: the deeper checks get their turn.
TEST(SurfaceReaderProperty, ValidFramesOverGarbageYieldOnlyDrawableSurfaces) {
  std::mt19937_64 random(4);
  const HostileSurfaces hostile;
  ASSERT_NE(hostile.reader, nullptr);
  SurfaceCopy copy;
  int drawable = 0, refused = 0;
  for (std::uint64_t round = 0; round < 3000; ++round) {
    protocol::SurfaceFrame frame;
    frame.vertex_change = random() % 50;
    frame.triangle_change = random() % 50;
    frame.vertex_count = static_cast<std::uint32_t>(random() % 3300);
    frame.triangle_count = static_cast<std::uint32_t>(random() % 4300);
    if (random() % 20 == 0) frame.vertex_count = static_cast<std::uint32_t>(random());
    protocol::SurfaceEntry& entry = hostile.Entry(0);
    entry.vertices_begun = frame.vertex_change + random() % 4;
    entry.triangles_begun = frame.triangle_change + random() % 4;
    protocol::StoreCell(entry.frame, protocol::SequenceOf(round), frame);
    if (random() % 3 == 0) {  // a corner or a coordinate that is none
      const std::size_t at =
          protocol::kSurfaceEntries + 2 * sizeof(protocol::SurfaceEntry) +
          random() % (hostile.bytes - protocol::kSurfaceEntries - 2 * sizeof(protocol::SurfaceEntry) - 8);
      const std::uint32_t value = random() % 2 == 0 ? 0x7FC00000U : static_cast<std::uint32_t>(random() % 2000);
      std::memcpy(hostile.memory + at / 4 * 4, &value, sizeof(value));
    }
    if (random() % 10 == 0)
      std::memset(hostile.memory + protocol::kSurfaceEntries + 2 * sizeof(protocol::SurfaceEntry), 0,
                  hostile.bytes - protocol::kSurfaceEntries - 2 * sizeof(protocol::SurfaceEntry));
    const std::uint64_t reader_before = copy.reader;
    SurfaceCopy fresh;
    (hostile.reader->Read(0, fresh) == SurfaceRead::kNothing ? refused : drawable) += 1;
    ExpectDrawable(*hostile.reader, 0, copy);
    if (HasFatalFailure()) FAIL() << "round " << round;
    EXPECT_GE(copy.reader, reader_before);
  }
  EXPECT_GT(drawable, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace test_ipc_surface_reader
}  // namespace omni
