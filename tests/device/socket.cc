// SocketTransport against a peer that the test plays itself: well, badly, or not at all.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "firmware/wire/messages.h"
#include "service/base/unique_fd.h"
#include "service/device/commands.h"
#include "service/device/socket_transport.h"

namespace omni::device {
namespace test_device_socket {

constexpr std::int64_t kPatience_ns = 2'000'000'000;
constexpr std::int64_t kShort_ns = 5'000'000;

using Frame = std::vector<std::uint8_t>;

wire::Hello GoodHello() {
  wire::Hello hello;
  hello.capabilities = wire::kDeviceClockIsHostMonotonic | wire::kSimulation;
  std::memcpy(hello.serial, "peer", 4);
  hello.field_lsb_T = 5e-8F;
  hello.field_full_scale = 27376;
  hello.current_max_A = 15;
  return hello;
}

Frame HelloFrame(const wire::Hello& hello) {
  Frame frame(wire::kFrameSizeMax);
  frame.resize(wire::Encode(hello, 0, 0, frame.data(), frame.size()).size);
  return frame;
}

Frame TelemetryFrame(std::uint16_t seq, std::uint64_t t_us) {
  wire::Telemetry telemetry;
  telemetry.field[0][0] = static_cast<std::int16_t>(seq);
  Frame frame(wire::kFrameSizeMax);
  frame.resize(wire::Encode(telemetry, seq, t_us, frame.data(), frame.size()).size);
  return frame;
}

struct Peer {
  base::UniqueFd theirs;  // the device's end
  base::UniqueFd ours;

  Peer() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
    ours = base::UniqueFd(ends[0]);
    theirs = base::UniqueFd(ends[1]);
  }
  void Send(const Frame& frame) const {
    EXPECT_EQ(send(theirs.get(), frame.data(), frame.size(), MSG_NOSIGNAL), static_cast<ssize_t>(frame.size()));
  }
  Frame Receive() const {
    Frame frame(wire::kFrameSizeMax);
    const ssize_t size = recv(theirs.get(), frame.data(), frame.size(), MSG_DONTWAIT);
    frame.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return frame;
  }
  std::unique_ptr<Transport> Connect(const wire::Hello& hello = GoodHello()) {
    Send(HelloFrame(hello));
    auto transport = MakeSocketTransport(std::move(ours), "test", kPatience_ns);
    EXPECT_TRUE(transport.ok());
    return transport.ok() ? std::move(transport.value()) : nullptr;
  }
};

TEST(SocketTransport, InfoComesFromHello) {
  Peer peer;
  const auto transport = peer.Connect();
  EXPECT_EQ(transport->info().name, "test");
  EXPECT_EQ(transport->info().serial, "peer");
  EXPECT_TRUE(transport->info().simulation);
  EXPECT_FALSE(transport->info().virtual_time);
}

TEST(SocketTransport, ReadReturnsNewestScanAndCountsTheRest) {
  Peer peer;
  const auto transport = peer.Connect();
  for (std::uint16_t seq = 1; seq <= 5; ++seq) peer.Send(TelemetryFrame(seq, 1000U * seq));
  peer.Send(TelemetryFrame(9, 9000));
  base::HallScan scan;
  ASSERT_EQ(transport->Read(scan, kPatience_ns), ReadStatus::kScan);
  EXPECT_EQ(scan.sequence, 9U);
  EXPECT_EQ(scan.t_ns, 9'000'000);
  EXPECT_EQ(transport->counters().received, 6U);
  EXPECT_EQ(transport->counters().superseded, 5U);
  EXPECT_EQ(transport->counters().missed, 3U);
  EXPECT_EQ(transport->Read(scan, kShort_ns), ReadStatus::kTimeout);
}

TEST(SocketTransport, CountsBadFramesAndReadsTheGoodOnes) {
  Peer peer;
  const auto transport = peer.Connect();
  Frame corrupt = TelemetryFrame(1, 1000);
  corrupt[30] ^= 4;
  peer.Send(corrupt);
  peer.Send({1, 2, 3});
  peer.Send(Frame(4000, 7));
  peer.Send(TelemetryFrame(2, 2000));
  peer.Send(TelemetryFrame(1, 1000));  // stale
  base::HallScan scan;
  ASSERT_EQ(transport->Read(scan, kPatience_ns), ReadStatus::kScan);
  EXPECT_EQ(scan.sequence, 2U);
  EXPECT_EQ(transport->counters().bad_frames, 4U);
  EXPECT_EQ(transport->counters().received, 1U);
}

TEST(SocketTransport, IgnoresUnknownTypesAndASecondHello) {
  Peer peer;
  const auto transport = peer.Connect();
  peer.Send(HelloFrame(GoodHello()));
  Frame unknown(64);
  wire::Header header;
  header.type = static_cast<wire::MessageType>(99);
  unknown.resize(wire::SealFrame(header, 8, unknown.data(), unknown.size()).size);
  peer.Send(unknown);
  base::HallScan scan;
  EXPECT_EQ(transport->Read(scan, kShort_ns), ReadStatus::kTimeout);
  EXPECT_EQ(transport->counters().bad_frames, 0U);
}

TEST(SocketTransport, WriteSendsAValidCommand) {
  Peer peer;
  const auto transport = peer.Connect();
  peer.Send(TelemetryFrame(1, 4242));
  base::HallScan scan;
  ASSERT_EQ(transport->Read(scan, kPatience_ns), ReadStatus::kScan);
  ASSERT_TRUE(transport->Write({{1.5, -2.25, 15}}));
  const Frame frame = peer.Receive();
  wire::FrameView view;
  ASSERT_EQ(wire::OpenFrame(frame.data(), frame.size(), view), wire::Status::kOk);
  wire::Command command;
  ASSERT_EQ(wire::DecodeCommand(view, 15, command), wire::Status::kOk);
  EXPECT_EQ(command.mode, wire::Mode::kCurrent);
  EXPECT_EQ(command.set_point_A[1], -2.25F);
  EXPECT_EQ(command.echo_device_us, 4242U);
  EXPECT_EQ(command.time_to_live_ms, kCommandTimeToLive_ms);
  EXPECT_EQ(transport->counters().sent, 1U);
  ASSERT_TRUE(transport->Write({}));
  const Frame zero = peer.Receive();
  ASSERT_EQ(wire::OpenFrame(zero.data(), zero.size(), view), wire::Status::kOk);
  ASSERT_EQ(wire::DecodeCommand(view, 15, command), wire::Status::kOk);
  EXPECT_EQ(command.time_to_live_ms, wire::kTimeToLiveMax_ms) << "zero current: a resting tick keeps the base armed";
}

TEST(SocketTransport, RequestsArmingWhereTheBaseRequiresIt) {
  Peer peer;
  wire::Hello hello = GoodHello();
  hello.capabilities |= wire::kArming;
  const auto transport = peer.Connect(hello);
  peer.Send(TelemetryFrame(1, 4242));
  base::HallScan scan;
  ASSERT_EQ(transport->Read(scan, kPatience_ns), ReadStatus::kScan);
  const Frame frame = peer.Receive();
  wire::FrameView view;
  wire::Arm arm;
  ASSERT_EQ(wire::OpenFrame(frame.data(), frame.size(), view), wire::Status::kOk);
  ASSERT_EQ(wire::Decode(view, arm), wire::Status::kOk);
  EXPECT_EQ(arm.step, wire::ArmStep::kRequest);
}

TEST(SocketTransport, NeverSendsInvalidSetPoints) {
  Peer peer;
  const auto transport = peer.Connect();
  EXPECT_FALSE(transport->Write({{std::nan(""), 0, 0}}));
  EXPECT_FALSE(transport->Write({{0, -INFINITY, 0}}));
  EXPECT_FALSE(transport->Write({{0, 0, 16}}));
  EXPECT_FALSE(transport->Write({{0, 0, 1e300}}));
  EXPECT_TRUE(peer.Receive().empty());
  EXPECT_EQ(transport->counters().send_failed, 4U);
}

TEST(SocketTransport, LastScanIsDeliveredBeforeGone) {
  Peer peer;
  const auto transport = peer.Connect();
  peer.Send(TelemetryFrame(1, 1000));
  peer.theirs.Reset();
  base::HallScan scan;
  EXPECT_EQ(transport->Read(scan, kPatience_ns), ReadStatus::kScan);
  EXPECT_EQ(transport->Read(scan, kPatience_ns), ReadStatus::kGone);
  EXPECT_EQ(transport->Read(scan, 0), ReadStatus::kGone);
  EXPECT_FALSE(transport->Write({{0, 0, 0}}));
}

TEST(SocketTransport, WriteNeverBlocksOnAFullSocket) {
  Peer peer;
  const auto transport = peer.Connect();
  int accepted = 0;
  while (accepted < 100000 && transport->Write({{0, 0, 0}})) ++accepted;
  EXPECT_LT(accepted, 100000);
  EXPECT_EQ(transport->counters().send_failed, 1U);
}

TEST(SocketTransport, ReadReturnsDespiteAFloodOfFrames) {
  Peer peer;
  const auto transport = peer.Connect();
  std::uint16_t seq = 0;
  for (int i = 0; i < 100000; ++i) {
    const Frame frame = TelemetryFrame(++seq, 1);
    if (send(peer.theirs.get(), frame.data(), frame.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) break;
  }
  base::HallScan scan;
  EXPECT_EQ(transport->Read(scan, kPatience_ns), ReadStatus::kScan);
}

TEST(SocketTransportOpening, ErrorsNameTheCause) {
  {
    Peer silent;
    const auto transport = MakeSocketTransport(std::move(silent.ours), "silent", kShort_ns);
    ASSERT_FALSE(transport.ok());
    EXPECT_NE(transport.error().find("silent: no HELLO in time (nothing arrived)"), std::string::npos)
        << transport.error();
  }
  {
    Peer gone;
    gone.theirs.Reset();
    const auto transport = MakeSocketTransport(std::move(gone.ours), "gone", kPatience_ns);
    ASSERT_FALSE(transport.ok());
    EXPECT_NE(transport.error().find("gone: the device closed the connection"), std::string::npos);
  }
  {
    Peer garbled;
    garbled.Send({9, 9, 9});
    const auto transport = MakeSocketTransport(std::move(garbled.ours), "garbled", kShort_ns);
    ASSERT_FALSE(transport.ok());
    EXPECT_NE(transport.error().find("frame too short"), std::string::npos) << transport.error();
  }
  {
    Peer wrong;
    wrong.Send(TelemetryFrame(1, 1));
    const auto transport = MakeSocketTransport(std::move(wrong.ours), "wrong", 0);
    ASSERT_FALSE(transport.ok());
    EXPECT_NE(transport.error().find("wrong: sends frames but no HELLO"), std::string::npos) << transport.error();
  }
  {
    Peer newer;
    wire::Hello hello = GoodHello();
    hello.version_min = hello.version_max = 9;
    newer.Send(HelloFrame(hello));
    const auto transport = MakeSocketTransport(std::move(newer.ours), "newer", kPatience_ns);
    ASSERT_FALSE(transport.ok());
    EXPECT_NE(transport.error().find("newer: device peer: speaks protocol versions 9 to 9"), std::string::npos)
        << transport.error();
  }
}

}  // namespace test_device_socket
}  // namespace omni::device
