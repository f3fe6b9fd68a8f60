// State memory: what the publisher makes, what the reader accepts.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <string>

#include "service/base/unique_fd.h"
#include "service/client/state_reader.h"
#include "service/ipc/state_publisher.h"
#include "service/protocol/sample_range.h"

namespace omni {
namespace test_ipc_state_memory {

using client::StateReader;
using ipc::StatePublisher;
using protocol::StateMemory;
using protocol::ToolSample;

constexpr int kAllSeals = F_SEAL_FUTURE_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
constexpr std::uint32_t kStateBytes = sizeof(StateMemory);

std::unique_ptr<StatePublisher> MakePublisher(std::uint64_t instance = 42) {
  return std::move(StatePublisher::Create(instance).value());
}

std::shared_ptr<const StateReader> ReaderOf(const StatePublisher& publisher) {
  auto reader = StateReader::Map(base::UniqueFd(::dup(publisher.fd())), kStateBytes);
  EXPECT_TRUE(reader.ok()) << reader.error();
  return *reader;
}

ToolSample SampleAt(std::int64_t t_ns) {
  ToolSample sample;
  sample.t_ns = t_ns;
  sample.flags = protocol::kToolPoseValid | protocol::kToolTracked;
  sample.position_base_m = {static_cast<double>(t_ns) * 1e-12, 0, 0.1};
  return sample;
}

TEST(StatePublisher, SealsItsMemory) {
  const auto publisher = MakePublisher();
  EXPECT_EQ(::fcntl(publisher->fd(), F_GET_SEALS), kAllSeals);
  EXPECT_NE(::fcntl(publisher->fd(), F_GETFD) & FD_CLOEXEC, 0);
}

TEST(StatePublisher, MemoryCannotBeWrittenOrResizedByOthers) {
  const auto publisher = MakePublisher();
  const char byte = 1;
  EXPECT_LT(::pwrite(publisher->fd(), &byte, 1, 0), 0);
  EXPECT_NE(::ftruncate(publisher->fd(), 4096), 0);
  EXPECT_NE(::ftruncate(publisher->fd(), kStateBytes * 2), 0);
  void* writable = ::mmap(nullptr, kStateBytes, PROT_READ | PROT_WRITE, MAP_SHARED, publisher->fd(), 0);
  EXPECT_EQ(writable, MAP_FAILED);
}

TEST(StateReader, SeesNothingBeforeTheFirstSample) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  ToolSample a;
  ToolSample b;
  protocol::InputSnapshot inputs;
  EXPECT_FALSE(reader->ReadNewest(a));
  EXPECT_FALSE(reader->ReadAround(5, a, b));
  EXPECT_FALSE(reader->ReadInputs(inputs));
  EXPECT_EQ(reader->service_instance(), 42u);
}

TEST(StateReader, ReadsThePublishedSample) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  ToolSample sample = SampleAt(1'000'000);
  sample.force_base_N = {0, 0, 1.5};
  sample.gap_m = 0.01;
  protocol::InputSnapshot inputs;
  inputs.t_ns = 1'000'000;
  inputs.components[1] = {1.0f, 3, 2, 0, 900'000};
  publisher->Publish(sample, inputs);
  ToolSample seen;
  ASSERT_TRUE(reader->ReadNewest(seen));
  EXPECT_EQ(seen.t_ns, 1'000'000);
  EXPECT_EQ(seen.force_base_N[2], 1.5);
  EXPECT_EQ(seen.gap_m, 0.01);
  protocol::InputSnapshot seen_inputs;
  ASSERT_TRUE(reader->ReadInputs(seen_inputs));
  EXPECT_EQ(seen_inputs.components[1].press_count, 3u);
  EXPECT_EQ(seen_inputs.components[1].t_change_ns, 900'000);
}

TEST(StateReader, KeepsAQuarterSecondOfHistory) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  std::int64_t newest_ns = 0;
  for (std::int64_t i = 0; i < 2000; ++i) publisher->Publish(SampleAt(newest_ns = i * 1'000'000), {});
  ToolSample before;
  ToolSample after;
  const std::int64_t asked_ns = newest_ns - 250'000'000 + 300'000;
  ASSERT_TRUE(reader->ReadAround(asked_ns, before, after));
  EXPECT_EQ(before.t_ns, newest_ns - 250'000'000);
  EXPECT_EQ(after.t_ns, newest_ns - 249'000'000);
}

TEST(StateReader, AroundClampsToTheEndsOfTheHistory) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  for (std::int64_t i = 1; i <= 2000; ++i) publisher->Publish(SampleAt(i * 1'000'000), {});
  ToolSample before;
  ToolSample after;
  ASSERT_TRUE(reader->ReadAround(std::numeric_limits<std::int64_t>::max(), before, after));
  EXPECT_EQ(before.t_ns, 2'000'000'000);
  EXPECT_EQ(after.t_ns, 2'000'000'000);
  ASSERT_TRUE(reader->ReadAround(std::numeric_limits<std::int64_t>::min(), before, after));
  EXPECT_EQ(before.t_ns, after.t_ns);
  EXPECT_EQ(before.t_ns, (2000 - (protocol::kRingCapacity - 2)) * std::int64_t{1'000'000});
}

TEST(StatePublisher, ReplacesInvalidSamplesByNoPose) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  ToolSample sample = SampleAt(5);
  sample.position_base_m[0] = std::numeric_limits<double>::quiet_NaN();
  protocol::InputSnapshot inputs;
  inputs.components[0].value = std::numeric_limits<float>::infinity();
  publisher->Publish(sample, inputs);
  ToolSample seen;
  ASSERT_TRUE(reader->ReadNewest(seen));
  EXPECT_EQ(seen.flags, 0u);
  EXPECT_EQ(seen.position_base_m[0], 0);
  protocol::InputSnapshot seen_inputs;
  ASSERT_TRUE(reader->ReadInputs(seen_inputs));
  EXPECT_EQ(seen_inputs.components[0].value, 1);
}

protocol::VehicleSnapshot CarAt(double x_m) {
  return {.t_ns = 1'000'000,
          .scene_generation = 3,
          .on = 1,
          .laps = 2,
          .position_base_m = {x_m, 0, 0.047},
          .heading_rad = 1.5,
          .speed_m_s = 0.05};
}

TEST(StateReader, ReadsTheVehicleWhileThereIsOne) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  protocol::VehicleSnapshot car;
  EXPECT_FALSE(reader->ReadVehicle(car));
  publisher->PublishVehicle({.t_ns = 5});
  ASSERT_TRUE(reader->ReadVehicle(car));
  EXPECT_EQ(car.on, 0U);
  for (const double x_m : {0.01, 0.02}) {
    publisher->PublishVehicle(CarAt(x_m));
    ASSERT_TRUE(reader->ReadVehicle(car));
    EXPECT_EQ(car.on, 1U);
    EXPECT_EQ(car.position_base_m[0], x_m);
    EXPECT_EQ(car.scene_generation, 3U);
    EXPECT_EQ(car.laps, 2U);
  }
  publisher->PublishVehicle({.t_ns = 7});
  ASSERT_TRUE(reader->ReadVehicle(car));
  EXPECT_EQ(car.on, 0U);
}

TEST(StatePublisher, InvalidVehicleIsPublishedAsNone) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  protocol::VehicleSnapshot car = CarAt(std::numeric_limits<double>::quiet_NaN());
  publisher->PublishVehicle(car);
  ASSERT_TRUE(reader->ReadVehicle(car));
  EXPECT_EQ(car.on, 0U);
  EXPECT_EQ(car.position_base_m[0], 0);
  car = CarAt(0.01);
  car.heading_rad = std::numeric_limits<double>::infinity();
  publisher->PublishVehicle(car);
  ASSERT_TRUE(reader->ReadVehicle(car));
  EXPECT_EQ(car.on, 0U);
}

TEST(StatePublisher, TimeNeverGoesBack) {
  const auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  publisher->Publish(SampleAt(10), {});
  publisher->Publish(SampleAt(7), {});
  ToolSample seen;
  ASSERT_TRUE(reader->ReadNewest(seen));
  EXPECT_EQ(seen.t_ns, 10);
}

TEST(StateReader, OutlivesItsPublisher) {
  auto publisher = MakePublisher();
  const auto reader = ReaderOf(*publisher);
  publisher->Publish(SampleAt(10), {});
  publisher.reset();
  ToolSample seen;
  EXPECT_TRUE(reader->ReadNewest(seen));
}

struct GoodHeader : protocol::StateHeader {
  GoodHeader() { total_bytes = kStateBytes; }
};

// A memory file as a broken or hostile service might pass.
int MakeFile(int seals, off_t bytes, const protocol::StateHeader& header) {
  const int fd = ::memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  EXPECT_EQ(::ftruncate(fd, bytes), 0);
  EXPECT_GT(::pwrite(fd, &header, std::min<std::size_t>(sizeof(header), static_cast<std::size_t>(bytes)), 0), 0);
  EXPECT_EQ(::fcntl(fd, F_ADD_SEALS, seals), 0);
  return fd;
}

std::string ErrorOf(int fd, std::uint32_t announced = kStateBytes) {
  const auto reader = StateReader::Map(base::UniqueFd(fd), announced);
  EXPECT_LT(::fcntl(fd, F_GETFD), 0) << "the descriptor was not taken over";
  return reader.ok() ? "accepted" : reader.error();
}

TEST(StateReader, RejectsMissingSeals) {
  const std::pair<int, const char*> seals[] = {{F_SEAL_FUTURE_WRITE, "F_SEAL_FUTURE_WRITE"},
                                               {F_SEAL_SHRINK, "F_SEAL_SHRINK"},
                                               {F_SEAL_GROW, "F_SEAL_GROW"},
                                               {F_SEAL_SEAL, "F_SEAL_SEAL"}};
  for (const auto& [seal, name] : seals) {
    const std::string error = ErrorOf(MakeFile(kAllSeals & ~seal, kStateBytes, GoodHeader{}));
    EXPECT_NE(error.find(name), std::string::npos) << error;
  }
}

TEST(StateReader, RejectsWrongSizes) {
  EXPECT_NE(ErrorOf(MakeFile(kAllSeals, kStateBytes - 64, GoodHeader{})).find("bytes"), std::string::npos);
  EXPECT_NE(ErrorOf(MakeFile(kAllSeals, kStateBytes * 2, GoodHeader{})).find("bytes"), std::string::npos);
  EXPECT_NE(ErrorOf(MakeFile(kAllSeals, kStateBytes, GoodHeader{}), 4096).find("announced"), std::string::npos);
}

TEST(StateReader, RejectsOtherLayouts) {
  const auto refused = [](void (*spoil)(protocol::StateHeader&)) {
    GoodHeader header;
    spoil(header);
    return ErrorOf(MakeFile(kAllSeals, kStateBytes, header));
  };
  EXPECT_NE(refused([](protocol::StateHeader& h) { h.magic = 1; }).find("magic"), std::string::npos);
  EXPECT_NE(refused([](protocol::StateHeader& h) {
              h.version = protocol::kStateVersion + 1;
            }).find("version " + std::to_string(protocol::kStateVersion + 1)),
            std::string::npos);
  EXPECT_NE(refused([](protocol::StateHeader& h) { h.ring_capacity = 1 << 20; }).find("layout"), std::string::npos);
  EXPECT_NE(refused([](protocol::StateHeader& h) { h.slot_bytes = 8; }).find("layout"), std::string::npos);
  EXPECT_NE(refused([](protocol::StateHeader& h) { h.vehicle_bytes = 8; }).find("layout"), std::string::npos);
  EXPECT_NE(refused([](protocol::StateHeader& h) { h.base_bytes = 8; }).find("layout"), std::string::npos);
  EXPECT_NE(refused([](protocol::StateHeader& h) { h.total_bytes = 1; }).find("layout"), std::string::npos);
}

TEST(StateReader, RejectsDescriptorsThatAreNotMemoryFiles) {
  EXPECT_NE(ErrorOf(::open("/dev/null", O_RDONLY | O_CLOEXEC)).find("sealable"), std::string::npos);
  EXPECT_NE(ErrorOf(-1).find("sealable"), std::string::npos);
}

}  // namespace test_ipc_state_memory
}  // namespace omni
