// Surface memory: what the publisher makes, what the reader copies, and what either refuses.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <limits>

#include "service/base/unique_fd.h"
#include "service/client/surface_reader.h"
#include "service/ipc/surface_publisher.h"

namespace omni {
namespace test_ipc_surface_memory {

using client::SurfaceCopy;
using client::SurfaceRead;
using client::SurfaceReader;
using ipc::SurfacePublish;
using ipc::SurfacePublisher;
using protocol::SurfacePlan;
using protocol::SurfacePoint;
using protocol::SurfaceTriangle;

constexpr int kSurfaceSeals = F_SEAL_FUTURE_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
constexpr ipc::SurfaceMemoryId kId{.service_instance = 42, .memory_generation = 1, .scene_generation = 9};

const SurfacePlan kSoftPlan{
    .name = "ball", .object = 3, .flags = protocol::kSurfaceSoft, .vertex_capacity = 4, .triangle_capacity = 2};
const SurfacePlan kClayPlan{.name = "clay",
                            .object = 4,
                            .flags = protocol::kSurfaceSculpted,
                            .vertex_capacity = 10,
                            .triangle_capacity = 10,
                            .triangles_change = true};
const SurfacePlan kCupPlan{.name = "cup", .object = 5, .flags = protocol::kSurfaceMoved};

const std::vector<SurfacePoint> kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
const std::vector<SurfaceTriangle> kTwo{{0, 1, 2}, {0, 2, 3}};

std::unique_ptr<SurfacePublisher> PublisherOf(const std::vector<SurfacePlan>& plans,
                                              const ipc::SurfaceMemoryId& id = kId) {
  auto made = SurfacePublisher::Create(id, plans);
  EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error());
  return std::move(*made);
}

std::shared_ptr<const SurfaceReader> ReaderOfSurfaces(const SurfacePublisher& publisher) {
  auto reader = SurfaceReader::Map(base::UniqueFd(::dup(publisher.fd())), publisher.bytes());
  EXPECT_TRUE(reader.ok()) << reader.error();
  return *reader;
}

TEST(SurfacePublisher, MemoryIsSealedAgainstOtherWriters) {
  const auto publisher = PublisherOf({kSoftPlan});
  EXPECT_EQ(::fcntl(publisher->fd(), F_GET_SEALS), kSurfaceSeals);
  EXPECT_NE(::ftruncate(publisher->fd(), 4096), 0);
  void* writable = ::mmap(nullptr, publisher->bytes(), PROT_READ | PROT_WRITE, MAP_SHARED, publisher->fd(), 0);
  EXPECT_EQ(writable, MAP_FAILED);
}

TEST(SurfacePublisher, RejectsPlansOverTheLimits) {
  SurfacePlan plan = kSoftPlan;
  plan.vertex_capacity = protocol::kMaxSurfaceVertices + 1;
  const auto made = SurfacePublisher::Create(kId, {&plan, 1});
  ASSERT_FALSE(made.ok());
  EXPECT_NE(made.error().find("object 0: 16777217 vertices, the limit is 16777216"), std::string::npos) << made.error();
  EXPECT_FALSE(SurfacePublisher::Create({.service_instance = 1}, {&kSoftPlan, 1}).ok()) << "generation 0";
}

TEST(SurfaceReader, ReportsOnlyWhatChanged) {
  const auto publisher = PublisherOf({kSoftPlan, kClayPlan, kCupPlan});
  const auto reader = ReaderOfSurfaces(*publisher);
  ASSERT_EQ(reader->object_count(), 3U);
  EXPECT_EQ(reader->object(0).name, "ball");
  EXPECT_EQ(reader->object(1).object, 4U);
  EXPECT_EQ(reader->object(2).flags, protocol::kSurfaceMoved);
  EXPECT_EQ(reader->scene_generation(), 9U);
  SurfaceCopy ball;
  EXPECT_EQ(reader->Read(0, ball), SurfaceRead::kNothing);

  ASSERT_EQ(publisher->Publish(0, {.t_ns = 5, .vertices_base_m = kSquare, .triangles = kTwo}), SurfacePublish::kDone);
  EXPECT_EQ(reader->Read(0, ball), SurfaceRead::kTriangles);
  EXPECT_EQ(ball.vertices_base_m, kSquare);
  EXPECT_EQ(ball.triangles, kTwo);
  EXPECT_EQ(ball.frame.t_ns, 5);
  EXPECT_EQ(reader->Read(0, ball), SurfaceRead::kUnchanged);

  std::vector<SurfacePoint> dented = kSquare;
  dented[2] = {1, 1, -0.001f};
  ASSERT_EQ(publisher->Publish(0, {.t_ns = 6, .vertices_base_m = dented, .largest_displacement_m = 0.001}),
            SurfacePublish::kDone);
  EXPECT_EQ(reader->Read(0, ball), SurfaceRead::kVertices);
  EXPECT_EQ(ball.vertices_base_m, dented);
  EXPECT_EQ(ball.triangles, kTwo);
  EXPECT_EQ(ball.frame.largest_displacement_m, 0.001);
}

TEST(SurfaceReader, SculptedSurfaceGrowsUpToItsCapacity) {
  const auto publisher = PublisherOf({kClayPlan});
  const auto reader = ReaderOfSurfaces(*publisher);
  SurfaceCopy clay;
  std::vector<SurfacePoint> points = kSquare;
  std::vector<SurfaceTriangle> triangles = kTwo;
  for (int round = 0; round < 6; ++round) {
    ASSERT_EQ(publisher->Publish(0, {.t_ns = round, .vertices_base_m = points, .triangles = triangles}),
              SurfacePublish::kDone);
    EXPECT_EQ(reader->Read(0, clay), SurfaceRead::kTriangles);
    EXPECT_EQ(clay.vertices_base_m, points);
    EXPECT_EQ(clay.triangles, triangles);
    points.push_back({static_cast<float>(round), 0, 1});
    triangles.push_back({0, 1, static_cast<std::uint32_t>(points.size() - 1)});
  }
  points.resize(11);
  EXPECT_EQ(publisher->Publish(0, {.vertices_base_m = points, .triangles = triangles}), SurfacePublish::kTooLarge);
  EXPECT_EQ(reader->Read(0, clay), SurfaceRead::kUnchanged);
}

TEST(SurfaceReader, AMovedObjectHasAPose) {
  const auto publisher = PublisherOf({kCupPlan});
  const auto reader = ReaderOfSurfaces(*publisher);
  SurfaceCopy cup;
  ASSERT_EQ(publisher->Publish(0, {.t_ns = 1}), SurfacePublish::kDone);
  EXPECT_EQ(reader->Read(0, cup), SurfaceRead::kPose);
  EXPECT_EQ(reader->Read(0, cup), SurfaceRead::kUnchanged);
  ASSERT_EQ(publisher->Publish(0, {.t_ns = 2, .rotation_wxyz = {0, 1, 0, 0}, .translation_m = {0, 0, 0.5}}),
            SurfacePublish::kDone);
  EXPECT_EQ(reader->Read(0, cup), SurfaceRead::kPose);
  EXPECT_EQ(cup.frame.translation_m[2], 0.5);
  EXPECT_EQ(cup.frame.rotation_wxyz[1], 1);
  EXPECT_TRUE(cup.vertices_base_m.empty());
}

TEST(SurfacePublisher, RejectsInvalidUpdates) {
  const auto publisher = PublisherOf({kSoftPlan, kCupPlan});
  const auto reader = ReaderOfSurfaces(*publisher);
  std::vector<SurfacePoint> points = kSquare;
  EXPECT_EQ(publisher->Publish(0, {.vertices_base_m = points}), SurfacePublish::kRefused) << "no triangles yet";
  points[0][0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(publisher->Publish(0, {.vertices_base_m = points, .triangles = kTwo}), SurfacePublish::kRefused);
  points = kSquare;
  points.pop_back();
  EXPECT_EQ(publisher->Publish(0, {.vertices_base_m = points, .triangles = kTwo}), SurfacePublish::kRefused)
      << "a corner beyond the last vertex";
  EXPECT_EQ(publisher->Publish(0, {.vertices_base_m = kSquare, .triangles = kTwo}), SurfacePublish::kDone);
  EXPECT_EQ(publisher->Publish(0, {.vertices_base_m = kSquare, .triangles = kTwo}), SurfacePublish::kRefused)
      << "triangles that must not change";
  EXPECT_EQ(publisher->Publish(1, {.rotation_wxyz = {2, 0, 0, 0}}), SurfacePublish::kRefused);
  EXPECT_EQ(publisher->Publish(1, {.vertices_base_m = kSquare}), SurfacePublish::kTooLarge);
  SurfaceCopy copy;
  EXPECT_EQ(reader->Read(0, copy), SurfaceRead::kTriangles);
  EXPECT_EQ(reader->Read(1, copy), SurfaceRead::kNothing);
}

// Changes of one memory mean nothing in another: they count from 1 in each.
TEST(SurfaceReader, CopyIsRefilledFromAnotherMemory) {
  const auto first = PublisherOf({kSoftPlan});
  const auto second = PublisherOf({kSoftPlan}, {.service_instance = 42, .memory_generation = 2});
  std::vector<SurfacePoint> other = kSquare;
  other[1] = {2, 0, 0};
  ASSERT_EQ(first->Publish(0, {.vertices_base_m = kSquare, .triangles = kTwo}), SurfacePublish::kDone);
  ASSERT_EQ(second->Publish(0, {.vertices_base_m = other, .triangles = kTwo}), SurfacePublish::kDone);
  SurfaceCopy copy;
  EXPECT_EQ(ReaderOfSurfaces(*first)->Read(0, copy), SurfaceRead::kTriangles);
  const auto reader = ReaderOfSurfaces(*second);
  EXPECT_EQ(reader->Read(0, copy), SurfaceRead::kTriangles);
  EXPECT_EQ(copy.vertices_base_m, other);
  EXPECT_EQ(reader->memory_generation(), 2U);
}

TEST(SurfaceReader, PulseCountsTheWritersPolls) {
  const auto publisher = PublisherOf({kSoftPlan});
  const auto reader = ReaderOfSurfaces(*publisher);
  protocol::SurfacePulse pulse;
  EXPECT_FALSE(reader->ReadPulse(pulse));
  publisher->PublishPulse(7);
  publisher->PublishPulse(8);
  ASSERT_TRUE(reader->ReadPulse(pulse));
  EXPECT_EQ(pulse.t_ns, 8);
  EXPECT_EQ(pulse.poll_count, 2U);
}

// Why a descriptor is refused; "accepted": it is not.
std::string ErrorOfSurfaces(int fd, std::uint64_t announced_bytes) {
  const auto reader = SurfaceReader::Map(base::UniqueFd(fd), announced_bytes);
  return reader.ok() ? "accepted" : reader.error();
}

TEST(SurfaceReader, RejectsInvalidMemory) {
  const auto publisher = PublisherOf({kSoftPlan});
  std::string error;
  error = ErrorOfSurfaces(::dup(publisher->fd()), publisher->bytes() + 64);
  EXPECT_NE(error.find("bytes, must have"), std::string::npos) << error;
  error = ErrorOfSurfaces(::dup(publisher->fd()), protocol::kMaxSurfaceBytes + 1);
  EXPECT_NE(error.find("announced"), std::string::npos) << error;
  error = ErrorOfSurfaces(::open("/dev/null", O_RDONLY | O_CLOEXEC), 4096);
  EXPECT_NE(error.find("sealable"), std::string::npos) << error;
  EXPECT_NE(ErrorOfSurfaces(-1, 4096).find("sealable"), std::string::npos);

  base::UniqueFd open_fd(::memfd_create("open", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  ASSERT_EQ(::ftruncate(open_fd.get(), 4096), 0);
  error = ErrorOfSurfaces(::dup(open_fd.get()), 4096);
  EXPECT_NE(error.find("lacks the seals"), std::string::npos) << error;
  ASSERT_EQ(::fcntl(open_fd.get(), F_ADD_SEALS, kSurfaceSeals), 0);
  error = ErrorOfSurfaces(::dup(open_fd.get()), 4096);
  EXPECT_NE(error.find("magic"), std::string::npos) << error;
}

}  // namespace test_ipc_surface_memory
}  // namespace omni
