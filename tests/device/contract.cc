// The contract of device::Transport, over every implementation there is: one row per factory.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/wire/messages.h"
#include "service/base/unique_fd.h"
#include "service/device/recording/device_recorder.h"
#include "service/device/recording/replay_transport.h"
#include "service/device/socket_transport.h"
#include "service/device/usb/usb_transport.h"
#include "service/sim/twin/twin.h"
#include "tests/support/chips/fake_usb.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/twin_scenario.h"

namespace omni::device {
namespace test_device_contract {

constexpr std::int64_t kPatience_ns = 5'000'000'000;
const base::Vec3 kTip{0.01, 0, 0.05};

sim::TwinOptions Options() { return support::HoldingTwin(kTip); }

// This test program doubles as the twin's process: started as `test_device --fd N [--record FILE]` it serves and ends
// before any test is run.
const bool kServed = [] {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  if (words.size() < 3 || words[1] != "--fd") return false;
  sim::TwinOptions options = Options();
  if (words.size() == 5) options.recording_path = words[4];
  _exit(sim::ServeTwin(support::NominalDevice(), options, std::atoi(words[2].c_str()), 0.15));
}();

std::string ThisProgram() {
  std::array<char, 4096> path{};
  const ssize_t size = readlink("/proc/self/exe", path.data(), path.size() - 1);
  return size > 0 ? std::string(path.data(), static_cast<std::size_t>(size)) : "";
}

// Objects that must outlive the transport; `link` is destroyed first.
struct Opened {
  std::shared_ptr<void> keeper;
  std::unique_ptr<Transport> link;
};

Opened OpenVirtual() { return {nullptr, sim::MakeVirtualTwin(support::NominalDevice(), Options(), 60)}; }

Opened OpenServedInThread() {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) std::abort();
  auto* server = new std::thread([fd = ends[1]] {
    sim::ServeTwin(support::NominalDevice(), Options(), fd, 0);
    close(fd);
  });
  std::shared_ptr<void> keeper(server, [](void* held) {
    auto* thread = static_cast<std::thread*>(held);
    thread->join();
    delete thread;
  });
  auto link = MakeSocketTransport(base::UniqueFd(ends[0]), "twin in a thread", kPatience_ns);
  return {std::move(keeper), link.ok() ? std::move(link.value()) : nullptr};
}

Opened OpenSpawned() {
  auto link = sim::SpawnTwin(ThisProgram(), {});
  EXPECT_TRUE(link.ok());
  return {nullptr, link.ok() ? std::move(link.value()) : nullptr};
}

// The real transport on a fake bus.
Opened OpenUsb() {
  auto bus = std::make_shared<test::FakeUsbBus>(true);
  test::FakeBase& base = bus->Add("A17").base;
  base.hello.capabilities = wire::kSimulation | wire::kCurrentSensors;
  base.faults = wire::kFaultHostSilent;
  base.follows = true;
  auto link = MakeUsbTransport(*bus, "");
  EXPECT_TRUE(link.ok());
  return {bus, link.ok() ? std::move(link.value()) : nullptr};
}

std::unique_ptr<Transport> Recorded(std::unique_ptr<Transport> inner, const std::string& path) {
  auto recorder =
      DeviceRecorder::Open(path, DescribeForRecording(inner->info(), support::NominalDevice().current_max_A));
  if (!recorder.ok()) return nullptr;
  return std::make_unique<RecordingTransport>(std::move(inner), std::move(*recorder));
}

Opened OpenRecorded() {
  auto folder = std::make_shared<test::TempFolder>();
  auto link = Recorded(OpenVirtual().link, folder->Path("device.rec"));
  return {std::move(folder), std::move(link)};
}

// Recorded from a host that behaves as those of the contract: silent at first, then commands currents.
Opened OpenReplayed(ReplayPace pace) {
  auto folder = std::make_shared<test::TempFolder>();
  const std::string path = folder->Path("device.rec");
  {
    auto link = Recorded(OpenVirtual().link, path);
    base::HallScan scan;
    for (int i = 0; i < 1500 && link != nullptr; ++i) {
      link->Read(scan, 0);
      if (i > 0) link->Write({{0.5, -1, 2}});
    }
  }
  auto link = OpenReplay(path, pace);
  EXPECT_TRUE(link.ok());
  return {std::move(folder), link.ok() ? std::move(*link) : nullptr};
}
Opened OpenReplayedFast() { return OpenReplayed(ReplayPace::kFast); }
Opened OpenReplayedInTime() { return OpenReplayed(ReplayPace::kRecorded); }

struct Row {
  const char* name;
  Opened (*open)();
  bool has_watchdog = true;  // a simulated base, not a recording or a fake
};

constexpr Row kTransports[] = {{"virtual_twin", OpenVirtual},
                               {"served_twin", OpenServedInThread},
                               {"spawned_twin", OpenSpawned},
                               {"recorded_twin", OpenRecorded},
                               {"replay_fast", OpenReplayedFast, false},
                               {"replay_in_time", OpenReplayedInTime, false},
                               {"usb", OpenUsb, false}};

class TransportContract : public testing::TestWithParam<Row> {
 protected:
  void SetUp() override {
    opened_ = GetParam().open();
    ASSERT_NE(opened_.link, nullptr);
  }
  // The next scan, and `currents` written in answer.
  ReadStatus Exchange(base::HallScan& scan, const base::CoilCurrents& currents) {
    const ReadStatus status = opened_.link->Read(scan, kPatience_ns);
    if (status != ReadStatus::kScan) return status;
    EXPECT_TRUE(opened_.link->Write(currents));
    return status;
  }
  Opened opened_;
};

TEST_P(TransportContract, InfoHasNameAndSimulationFlag) {
  EXPECT_FALSE(opened_.link->info().name.empty());
  EXPECT_TRUE(opened_.link->info().simulation);
}

TEST_P(TransportContract, ScansAreOrderedAndPlausible) {
  base::HallScan before;
  base::HallScan scan;
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(opened_.link->Read(scan, kPatience_ns), ReadStatus::kScan);
    ASSERT_GT(scan.sequence, before.sequence);
    ASSERT_GT(scan.t_ns, before.t_ns);
    before = scan;
    for (std::size_t s = 0; s < base::kSensorCount; ++s) {
      const base::Vec3& b = scan.field_sensor_T[s];
      ASSERT_TRUE(std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.z));
      ASSERT_GE(scan.age_ns[s], 0);
    }
    ASSERT_EQ(scan.saturated_mask >> 24, 0U);
    ASSERT_NEAR(scan.supply_V, 18, 0.05);
    ASSERT_NEAR(scan.coil_temperature_C[0], 24, 3);  // by its resistance
  }
  EXPECT_GE(opened_.link->counters().received, 50U);
  EXPECT_EQ(opened_.link->counters().bad_frames, 0U);
}

TEST_P(TransportContract, FaultsClearOnceCommandsArrive) {
  base::HallScan scan;
  ASSERT_EQ(opened_.link->Read(scan, kPatience_ns), ReadStatus::kScan);
  EXPECT_NE(scan.device_faults, 0U);
  EXPECT_EQ(scan.device_faults & ~wire::kFaultsOfTheHost, 0U);
  bool cleared = false;
  for (int i = 0; i < 2000 && !cleared; ++i) {
    ASSERT_EQ(Exchange(scan, {}), ReadStatus::kScan);
    cleared = scan.device_faults == 0;
  }
  EXPECT_TRUE(cleared);
}

TEST_P(TransportContract, ReachesTheCommandedCurrents) {
  base::HallScan scan;
  const base::CoilCurrents wanted{{0.5, -1, 2}};
  bool reached = false;
  for (int i = 0; i < 5000 && !reached; ++i) {
    ASSERT_EQ(Exchange(scan, wanted), ReadStatus::kScan);
    reached = true;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      reached = reached && std::abs(scan.coil_current_A[k] - wanted.current_A[k]) < 0.03;
    }
  }
  EXPECT_TRUE(reached);
}

TEST_P(TransportContract, WriteRejectsInvalidSetPoints) {
  const std::uint64_t sent = opened_.link->counters().sent;
  EXPECT_FALSE(opened_.link->Write({{std::nan(""), 0, 0}}));
  EXPECT_FALSE(opened_.link->Write({{0, 0, INFINITY}}));
  EXPECT_FALSE(opened_.link->Write({{0, -99, 0}}));
  EXPECT_EQ(opened_.link->counters().sent, sent);
  EXPECT_EQ(opened_.link->counters().send_failed, 3U);
}

TEST_P(TransportContract, CountersAreReadableFromAnyThread) {
  std::atomic<bool> done{false};
  std::thread reader([&] {
    std::uint64_t received = 0;
    while (!done) {
      const TransportCounters now = opened_.link->counters();
      EXPECT_GE(now.received, received);
      received = now.received;
    }
  });
  base::HallScan scan;
  for (int i = 0; i < 100; ++i) Exchange(scan, {});  // where the newest command wins, one may replace another
  done = true;
  reader.join();
  EXPECT_GE(opened_.link->counters().sent, 50U);
}

// Silence is a fault that ends by itself when the host returns.
TEST_P(TransportContract, HostSilenceFaultClearsWhenCommandsResume) {
  if (!GetParam().has_watchdog) return;
  base::HallScan scan;
  const auto until = [&](std::uint32_t faults, bool commands) {
    for (int i = 0; i < 2000; ++i) {
      if (opened_.link->Read(scan, kPatience_ns) != ReadStatus::kScan) return false;
      if (commands) opened_.link->Write({{1, 0, 0}});
      if ((scan.device_faults & faults) == faults && (scan.device_faults == 0) == (faults == 0)) return true;
    }
    return false;
  };
  ASSERT_TRUE(until(0, true));
  ASSERT_TRUE(until(wire::kFaultHostSilent, false));
  ASSERT_TRUE(until(0, true));
}

INSTANTIATE_TEST_SUITE_P(AllTransports, TransportContract, testing::ValuesIn(kTransports),
                         [](const testing::TestParamInfo<Row>& row) { return std::string(row.param.name); });

TEST(SpawnedTwin, ErrorsSayWhyTheTwinDidNotStart) {
  const auto missing = sim::SpawnTwin("/nonexistent/omni", {});
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().find("/nonexistent/omni: the twin cannot be started"), std::string::npos);
  const auto mute = sim::SpawnTwin("/bin/true", {});
  ASSERT_FALSE(mute.ok());
  EXPECT_NE(mute.error().find("closed the connection before its HELLO"), std::string::npos) << mute.error();
}

// The host closes the link without notice while the coils carry current: the twin keeps recording, and records zero.
TEST(SpawnedTwin, OutlivesItsHostAndRecordsZeroCurrents) {
  const test::TempFolder folder;
  const std::string path = folder.Path("truth.csv");
  {
    auto link = sim::SpawnTwin(ThisProgram(), {"--record", path});
    ASSERT_TRUE(link.ok()) << link.error();
    base::HallScan scan;
    for (int i = 0; i < 5000 && !(scan.coil_current_A[2] > 4.9); ++i) {
      ASSERT_EQ(link.value()->Read(scan, kPatience_ns), ReadStatus::kScan);
      ASSERT_TRUE(link.value()->Write({{0, 0, 5}}));
    }
    ASSERT_GT(scan.coil_current_A[2], 4.9);
  }  // waits for the twin's end
  const support::Table table = support::ReadTable(path);
  ASSERT_GT(table.rows.size(), 10U);
  const std::size_t last = table.rows.size() - 1;
  EXPECT_LT(std::abs(table.At(last, "current_z_A")), 0.01);
  EXPECT_EQ(table.At(last, "faults"), wire::kFaultsOfTheHost);
  double peak_A = 0;
  for (std::size_t i = 0; i <= last; ++i) {
    peak_A = std::max(peak_A, table.At(i, "current_z_A"));
    if (!(table.At(i, "command_age_s") > 0.045)) continue;
    EXPECT_LT(std::abs(table.At(i, "current_z_A")), 0.05) << i;
  }
  EXPECT_GT(peak_A, 4.9);
}

TEST(ServedTwin, RejectsDescriptorsThatAreNotSeqpacketSockets) {
  testing::internal::CaptureStderr();
  EXPECT_NE(sim::ServeTwin(support::NominalDevice(), Options(), STDIN_FILENO, 0), 0);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("is not a seqpacket socket"), std::string::npos);
}

// Only a valid command feeds the watchdog.
TEST(ServedTwin, InvalidFramesAreRejectedAndNeverEnableTheCoils) {
  int ends[2] = {-1, -1};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
  std::thread server([fd = ends[1]] {
    sim::ServeTwin(support::NominalDevice(), Options(), fd, 0);
    close(fd);
  });
  base::UniqueFd host(ends[0]);
  wire::Telemetry telemetry;
  std::array<std::uint8_t, wire::kFrameSizeMax> buffer{};
  for (int i = 0; i < 2000 && telemetry.rejected < 3; ++i) {
    const std::array<std::uint8_t, 24> garbage{'O', 'M', 1, 3};
    send(host.get(), garbage.data(), garbage.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    const ssize_t size = recv(host.get(), buffer.data(), buffer.size(), 0);
    wire::FrameView view;
    if (size > 0 && wire::OpenFrame(buffer.data(), static_cast<std::size_t>(size), view) == wire::Status::kOk) {
      wire::Decode(view, telemetry);
    }
  }
  EXPECT_GE(telemetry.rejected, 3);
  EXPECT_EQ(telemetry.faults, wire::kFaultNotArmed);
  host.Reset();
  server.join();
}

}  // namespace test_device_contract
}  // namespace omni::device
