// A base that sends arbitrary frames: nothing crashes, scans are finite, and the host sends only harmless frames or
// valid set-points to a base that reports itself armed. scripts/fuzz runs more frames, through OMNI_FUZZ.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "service/device/usb/usb_session.h"
#include "tests/support/chips/fake_usb.h"

namespace omni::device {
namespace test_device_usb_frames {

using test::FakeBase;
using test::UsbFrame;

constexpr float kCurrentMax_A = 15;

std::uint64_t Frames() {
  const char* wanted = std::getenv("OMNI_FUZZ");
  return wanted == nullptr ? 200'000 : std::strtoull(wanted, nullptr, 10);
}

class Liar {
 public:
  explicit Liar(std::uint32_t seed) : random_(seed) {}

  UsbFrame Next() {
    switch (Below(9)) {
      case 0:
        return Noise(Below(600));
      case 1:
        return Sealed(static_cast<wire::MessageType>(Below(10)), Below(200));
      case 2:
        return Sealed(wire::MessageType::kTelemetry, wire::PayloadSize<wire::Telemetry>() + Below(3));
      case 3: {
        UsbFrame frame = base_.Tick();
        frame[Below(frame.size())] ^= static_cast<std::uint8_t>(1U << Below(8));
        return frame;
      }
      case 4:
        if (Below(2) == 0) return base_.Frame(Note<wire::FaultEvent>());
        return base_.Frame(Note<wire::Log>());
      case 5: {
        wire::Arm arm;
        arm.step = static_cast<wire::ArmStep>(1 + Below(5));
        arm.nonce = static_cast<std::uint32_t>(random_());
        arm.faults = Below(4) == 0 ? 1U << Below(20) : 0;
        return base_.Frame(arm);
      }
      default:
        base_.state = static_cast<wire::State>(Below(5));
        base_.faults = Below(200) == 0 ? 1U << Below(32) : base_.state == wire::State::kArmed ? 0 : 1;
        return base_.Tick();
    }
  }

  // The first frame of a new base, its HELLO.
  UsbFrame Restart() {
    base_ = {};
    return base_.Frame(base_.hello);
  }

  double Current_A() {
    switch (Below(6)) {
      case 0:
        return std::nan("");
      case 1:
        return 1e30;
      default:
        return std::uniform_real_distribution<double>(-20, 20)(random_);
    }
  }
  std::size_t Below(std::size_t n) { return random_() % n; }

 private:
  // Any contents that its decoder accepts.
  template <class Message>
  Message Note() {
    for (;;) {
      UsbFrame frame = Noise(wire::FrameSize<Message>());
      frame[wire::kHeaderSize] = static_cast<std::uint8_t>(Below(4));                          // of LOG: its level
      frame[wire::kHeaderSize + 1] = static_cast<std::uint8_t>(Below(wire::kLogTextMax + 1));  // its size
      frame[wire::kHeaderSize + 8] = static_cast<std::uint8_t>(Below(5));                      // of FAULT: its state
      wire::Header header;
      header.type = Message::kType;
      wire::SealFrame(header, wire::PayloadSize<Message>(), frame.data(), frame.size());
      wire::FrameView view;
      Message message;
      if (wire::OpenFrame(frame.data(), frame.size(), view) == wire::Status::kOk &&
          wire::Decode(view, message) == wire::Status::kOk) {
        return message;
      }
    }
  }
  UsbFrame Noise(std::size_t size) {
    UsbFrame frame(size);
    for (std::uint8_t& byte : frame) byte = static_cast<std::uint8_t>(random_());
    return frame;
  }
  // A good envelope around anything; mostly in order.
  UsbFrame Sealed(wire::MessageType type, std::size_t payload) {
    UsbFrame frame = Noise(wire::kFrameSizeMax);
    wire::Header header;
    header.type = type;
    header.seq = Below(8) == 0 ? static_cast<std::uint16_t>(random_()) : base_.seq++;
    header.t_device_us = Below(200) == 0 ? (std::uint64_t{random_()} << 32 | random_()) : base_.t_us;
    frame.resize(wire::SealFrame(header, payload, frame.data(), frame.size()).size);
    return frame;
  }

  std::mt19937 random_;
  FakeBase base_;
};

void ExpectSane(const base::HallScan& scan) {
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const base::Vec3& b = scan.field_sensor_T[i];
    ASSERT_TRUE(std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.z));
    ASSERT_GE(scan.age_ns[i], 0);
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    ASSERT_TRUE(std::isfinite(scan.coil_current_A[k]) && std::isfinite(scan.coil_temperature_C[k]));
  }
  ASSERT_EQ(scan.saturated_mask >> (3 * base::kSensorCount), 0U);
}

// As omnid logs them: one line of printable characters.
std::size_t PopNotes(UsbSession& session) {
  std::size_t count = 0;
  for (BaseNote note; session.PopNote(note); ++count) {
    const std::string text = note.type == wire::MessageType::kFault ? FaultEventText(note.fault)
                                                                    : PrintableText(note.log.text, note.log.size);
    EXPECT_LT(text.size(), 200U);
    for (const char c : text) EXPECT_TRUE(c >= ' ' && c <= '~') << static_cast<int>(c);
  }
  return count;
}

// Fetches everything the session wants to send; true: it included a set-point.
bool CheckSent(UsbSession& session) {
  bool drives = false;
  for (int i = 0;; ++i) {
    EXPECT_LT(i, 8) << "the session never stops sending";
    UsbFrame frame(wire::kFrameSizeMax);
    frame.resize(session.NextFrame(base::MonotonicNow_ns(), frame.data(), frame.size()));
    if (frame.empty() || i >= 8) return drives;
    wire::FrameView view;
    EXPECT_EQ(wire::OpenFrame(frame.data(), frame.size(), view), wire::Status::kOk);
    if (view.header.type != wire::MessageType::kCommand) continue;
    wire::Command command;
    EXPECT_EQ(wire::DecodeCommand(view, kCurrentMax_A, command), wire::Status::kOk);
    if (command.mode == wire::Mode::kOff) {
      for (const float set_point_A : command.set_point_A) EXPECT_EQ(set_point_A, 0);
      continue;
    }
    drives = true;
    const TransportState state = session.state();
    EXPECT_EQ(state.state, static_cast<std::uint8_t>(wire::State::kArmed));
    EXPECT_EQ(state.faults, 0U);
  }
}

std::unique_ptr<UsbSession> Open(Liar& liar) {
  auto session = std::make_unique<UsbSession>();
  const UsbFrame hello = liar.Restart();
  session->OnFrame(hello.data(), hello.size(), base::MonotonicNow_ns());
  EXPECT_EQ(session->WaitForHello(0), UsbSession::Hello::kHere);
  session->Begin(*InfoFromHello(session->hello(), Clocks::kAny));
  return session;
}

TEST(UsbSessionFuzz, ArbitraryFramesNeverCauseInvalidCommands) {
  Liar liar(20261121);
  std::unique_ptr<UsbSession> session = Open(liar);
  std::uint64_t scans = 0, drives = 0, refused = 0, reopened = 0, notes = 0;
  const std::uint64_t frames = Frames();
  for (std::uint64_t i = 0; i < frames && !testing::Test::HasFailure(); ++i) {
    const UsbFrame frame = liar.Next();
    session->OnFrame(frame.data(), frame.size(), base::MonotonicNow_ns());
    base::HallScan scan;
    const ReadStatus read = session->Read(scan, 0);
    if (read == ReadStatus::kScan) {
      ++scans;
      ExpectSane(scan);
    }
    session->Write({{liar.Current_A(), liar.Current_A(), liar.Current_A()}});
    drives += CheckSent(*session) ? 1 : 0;
    notes += PopNotes(*session);
    if (read != ReadStatus::kGone && liar.Below(2000) != 0) continue;
    refused += session->counters().bad_frames;
    session = Open(liar);
    ++reopened;
  }
  // The random frames must have reached everything, otherwise the test proves nothing.
  EXPECT_GT(scans, frames / 20);
  EXPECT_GT(drives, frames / 1000);
  EXPECT_GT(refused, frames / 20);
  EXPECT_GT(reopened, frames / 5000);
  EXPECT_GT(notes, frames / 20);
  for (const auto& [name, value] : {std::pair<const char*, std::uint64_t>{"frames", frames},
                                    {"refused", refused},
                                    {"scans", scans},
                                    {"commands_checked", drives},
                                    {"notes", notes}}) {
    RecordProperty(name, std::to_string(value));
  }
}

// The same before HELLO: only a valid HELLO is accepted, and only requests are sent.
TEST(UsbSessionFuzz, SendsNoSetPointsBeforeHello) {
  Liar liar(7);
  for (int run = 0; run < 200; ++run) {
    UsbSession session;
    for (int i = 0; i < 200; ++i) {
      const UsbFrame frame = liar.Next();
      session.OnFrame(frame.data(), frame.size(), base::MonotonicNow_ns());
      EXPECT_FALSE(CheckSent(session));
    }
    base::HallScan scan;
    EXPECT_NE(session.Read(scan, 0), ReadStatus::kScan);
    if (session.WaitForHello(0) != UsbSession::Hello::kHere) continue;
    EXPECT_TRUE(std::isfinite(session.hello().field_lsb_T) && session.hello().current_max_A > 0);
  }
}

}  // namespace test_device_usb_frames
}  // namespace omni::device
