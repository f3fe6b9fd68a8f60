// UsbSession against a fake base, frame by frame: HELLO, arming, newest wins, bad input, unplugging.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <thread>

#include "service/device/commands.h"
#include "service/device/usb/usb_session.h"
#include "tests/support/chips/fake_usb.h"

namespace omni::device {
namespace test_device_usb_session {

using test::FakeBase;
using test::FakeUsbLink;
using test::UsbFrame;

constexpr std::int64_t kNow = 0;
constexpr std::int64_t kShort_ns = 2'000'000;

class UsbSessionTest : public testing::Test {
 protected:
  UsbSessionTest() : link_(base_) {}

  // From here on as MakeUsbTransport does it.
  void Begin() {
    session_.Attach(link_);
    ASSERT_TRUE(link_.Start(session_).ok());
    ASSERT_EQ(session_.WaitForHello(kShort_ns), UsbSession::Hello::kHere);
    const auto info = InfoFromHello(session_.hello(), Clocks::kAny);
    ASSERT_TRUE(info.ok()) << info.error();
    session_.Begin(*info);
  }
  // `n` milliseconds of the tick: a scan is read, currents are written.
  void Live(int n, const base::CoilCurrents& currents = {{1, 2, 3}}) {
    for (int i = 0; i < n; ++i) {
      link_.Step();
      base::HallScan scan;
      ASSERT_EQ(session_.Read(scan, kNow), ReadStatus::kScan);
      ASSERT_TRUE(session_.Write(currents));
      link_.Pump();
    }
  }
  // A telemetry frame of the base with altered bytes.
  UsbFrame Bent(const std::function<void(UsbFrame&)>& bend) {
    UsbFrame frame = base_.Tick();
    bend(frame);
    return frame;
  }

  FakeBase base_;
  UsbSession session_;  // outlives the link
  FakeUsbLink link_;
};

TEST_F(UsbSessionTest, ReceivesHelloOnRequest) {
  Begin();
  EXPECT_EQ(base_.seqs.size(), 1U);
  EXPECT_EQ(InfoFromHello(session_.hello(), Clocks::kAny)->serial, "A17");
}

TEST_F(UsbSessionTest, RepeatsHelloRequestAndTimesOut) {
  base_.answers_hello = false;
  session_.Attach(link_);
  ASSERT_TRUE(link_.Start(session_).ok());
  EXPECT_EQ(session_.WaitForHello(kShort_ns), UsbSession::Hello::kMissing);
  EXPECT_EQ(base_.seqs.size(), 1U) << "not more often than every 100 ms";
  UsbFrame again(wire::kFrameSizeMax);
  EXPECT_GT(session_.NextFrame(base::MonotonicNow_ns() + 200'000'000, again.data(), again.size()), 0U);
}

TEST_F(UsbSessionTest, IgnoresTelemetryBeforeBegin) {
  session_.Attach(link_);
  ASSERT_TRUE(link_.Start(session_).ok());
  link_.Step();
  base::HallScan scan;
  EXPECT_EQ(session_.Read(scan, kNow), ReadStatus::kTimeout);
  EXPECT_TRUE(base_.arms.empty());
  EXPECT_TRUE(base_.commands.empty());
}

TEST_F(UsbSessionTest, ArmsInTwoStepsBeforeSendingSetPoints) {
  Begin();
  Live(10);
  ASSERT_EQ(base_.arms.size(), 2U);
  EXPECT_EQ(base_.arms[0].step, wire::ArmStep::kRequest);
  EXPECT_EQ(base_.arms[1].step, wire::ArmStep::kConfirm);
  EXPECT_EQ(base_.arms[1].nonce, base_.nonce);
  ASSERT_GE(base_.commands.size(), 8U);
  EXPECT_EQ(base_.commands.front().mode, wire::Mode::kOff) << "the base receives commands before it is armed";
  EXPECT_EQ(base_.commands.front().set_point_A[2], 0);
  EXPECT_EQ(base_.commands.back().mode, wire::Mode::kCurrent);
  EXPECT_EQ(base_.commands.back().set_point_A[2], 3);
  EXPECT_EQ(base_.commands.back().time_to_live_ms, kCommandTimeToLive_ms);
  EXPECT_EQ(base_.bad, 0);
}

TEST_F(UsbSessionTest, SkipsArmingWhereTheBaseNeedsNone) {
  base_.hello.capabilities = 0;
  base_.faults = 0;
  Begin();
  Live(5);
  EXPECT_TRUE(base_.arms.empty());
  EXPECT_EQ(base_.commands.front().mode, wire::Mode::kCurrent);
}

TEST_F(UsbSessionTest, RearmsAfterHostSilence) {
  Begin();
  Live(5);
  ASSERT_EQ(base_.state, wire::State::kArmed);
  base_.state = wire::State::kIdle;
  base_.faults = wire::kFaultHostSilent | wire::kFaultNotArmed;
  Live(5);
  EXPECT_EQ(base_.arms.size(), 4U);
  EXPECT_EQ(base_.state, wire::State::kArmed);
  EXPECT_FALSE(session_.state().waits_for_person);
}

TEST_F(UsbSessionTest, NeverRearmsByItselfAfterAnyOtherFault) {
  for (std::uint32_t bit = wire::kFaultOverTemperature; bit <= wire::kFaultInternal; bit <<= 1) {
    FakeBase base;
    UsbSession session;
    FakeUsbLink link(base);
    session.Attach(link);
    ASSERT_TRUE(link.Start(session).ok());
    session.Begin(*InfoFromHello(session.hello(), Clocks::kAny));
    const auto live = [&](int n) {
      for (int i = 0; i < n; ++i) {
        link.Step();
        ASSERT_TRUE(session.Write({{1, 1, 1}}));
        link.Pump();
      }
    };
    live(5);
    ASSERT_EQ(base.state, wire::State::kArmed);
    const std::size_t arms = base.arms.size();
    base.state = wire::State::kFault;
    base.faults = bit;
    live(5);
    EXPECT_TRUE(session.state().waits_for_person);
    EXPECT_EQ(session.state().faults, bit);
    EXPECT_EQ(base.commands.back().mode, wire::Mode::kOff) << bit;
    base.state = wire::State::kIdle;  // the cause disappears
    base.faults = wire::kFaultNotArmed;
    live(300);
    EXPECT_EQ(base.arms.size(), arms) << "bit " << bit;
    EXPECT_EQ(base.commands.back().mode, wire::Mode::kOff) << bit;
  }
}

TEST_F(UsbSessionTest, DoesNotArmDuringTheSelfTest) {
  base_.state = wire::State::kSelfTest;
  Begin();
  Live(10);
  EXPECT_TRUE(base_.arms.empty());
  base_.state = wire::State::kIdle;
  Live(5);
  EXPECT_EQ(base_.state, wire::State::kArmed);
}

TEST_F(UsbSessionTest, RetriesRefusedArmingAtMostOncePerPause) {
  base_.refuses_arm = wire::kFaultHostSilent;
  Begin();
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  Live(50);
  const std::int64_t pauses = (base::MonotonicNow_ns() - begin_ns) / Arming::kPause_ns;
  EXPECT_GE(base_.arms.size(), 1U);
  EXPECT_LE(base_.arms.size(), static_cast<std::size_t>(1 + pauses));
  EXPECT_FALSE(session_.state().waits_for_person);
}

TEST_F(UsbSessionTest, RefusalForAnotherFaultIsNotRetried) {
  base_.refuses_arm = wire::kFaultSupplyLow;
  Begin();
  Live(5);
  EXPECT_TRUE(session_.state().waits_for_person);
  base_.refuses_arm = 0;
  Live(5);
  EXPECT_EQ(base_.arms.size(), 1U);
}

TEST_F(UsbSessionTest, RejectsUnsolicitedChallenges) {
  Begin();
  Live(5);
  const std::size_t arms = base_.arms.size();
  wire::Arm challenge;
  challenge.step = wire::ArmStep::kChallenge;
  challenge.nonce = 1;
  link_.Give(base_.Frame(challenge));
  link_.Pump();
  EXPECT_EQ(base_.arms.size(), arms);
  EXPECT_EQ(session_.counters().bad_frames, 1U);
}

TEST_F(UsbSessionTest, ReadReturnsNewestScanAndCountsTheRest) {
  Begin();
  for (int i = 0; i < 5; ++i) {
    base_.telemetry.field[0][0] = static_cast<std::int16_t>(100 * i);
    link_.Give(base_.Tick());
  }
  base::HallScan scan;
  ASSERT_EQ(session_.Read(scan, kNow), ReadStatus::kScan);
  EXPECT_NEAR(scan.field_sensor_T[0].x, 400 * 5.8e-8, 1e-10);
  EXPECT_EQ(session_.counters().received, 5U);
  EXPECT_EQ(session_.counters().superseded, 4U);
  EXPECT_EQ(session_.Read(scan, kNow), ReadStatus::kTimeout) << "a scan is read once";
}

TEST_F(UsbSessionTest, SendsOnlyTheNewestCommand) {
  Begin();
  Live(5);
  const std::size_t before = base_.commands.size();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(session_.Write({{0.1 * i, 0, 0}}));
  link_.Pump();
  ASSERT_EQ(base_.commands.size(), before + 1);
  EXPECT_FLOAT_EQ(base_.commands.back().set_point_A[0], 0.9F);
  EXPECT_EQ(link_.wakes.load(), 15);
}

TEST_F(UsbSessionTest, DropsCommandsDelayedByTheBus) {
  Begin();
  Live(5);
  ASSERT_TRUE(session_.Write({{1, 0, 0}}));
  UsbFrame frame(wire::kFrameSizeMax);
  EXPECT_EQ(session_.NextFrame(base::MonotonicNow_ns() + 30'000'000, frame.data(), frame.size()), 0U);
  EXPECT_EQ(session_.counters().send_failed, 1U);
}

// A resting tick writes only every 16 ms; without repeats the base would take every delay for a silent host.
TEST_F(UsbSessionTest, RepeatsOnlyZeroCurrentAndForLimitedTime) {
  Begin();
  UsbFrame frame(wire::kFrameSizeMax);
  std::int64_t written_ns = 0;
  const auto again = [&](std::int64_t after_ms) {
    return session_.NextFrame(written_ns + after_ms * 1'000'000, frame.data(), frame.size());
  };
  Live(5, {});
  written_ns = base::MonotonicNow_ns();
  const std::size_t size = again(6);
  ASSERT_GT(size, 0U);
  wire::FrameView view;
  wire::Command command;
  ASSERT_EQ(wire::OpenFrame(frame.data(), size, view), wire::Status::kOk);
  ASSERT_EQ(wire::DecodeCommand(view, 15, command), wire::Status::kOk);
  for (const float set_point_A : command.set_point_A) EXPECT_EQ(set_point_A, 0);
  EXPECT_EQ(again(7), 0U) << "not more often than needed";
  EXPECT_EQ(again(110), 0U) << "a tick that does not write for so long is stuck";
  Live(1, {{0, 0.001, 0}});
  written_ns = base::MonotonicNow_ns();
  EXPECT_EQ(again(6), 0U) << "a current is never repeated";
}

// Including those before Begin: a base reports faults as soon as it starts.
TEST_F(UsbSessionTest, QueuesFaultAndLogFramesAsNotes) {
  BaseNote note;
  EXPECT_FALSE(session_.PopNote(note));
  wire::Log line;
  line.level = wire::LogLevel::kWarning;
  line.size = 5;
  std::memcpy(line.text, "hello", 5);
  const UsbFrame early = base_.Frame(line);
  session_.OnFrame(early.data(), early.size(), base::MonotonicNow_ns());
  Begin();
  link_.Give(base_.Frame(FakeBase::KeptFault()));
  Live(3);
  ASSERT_TRUE(session_.PopNote(note));
  EXPECT_EQ(note.type, wire::MessageType::kLog);
  EXPECT_EQ(PrintableText(note.log.text, note.log.size), "hello");
  ASSERT_TRUE(session_.PopNote(note));
  EXPECT_EQ(note.type, wire::MessageType::kFault);
  EXPECT_EQ(note.fault.part, 2);
  EXPECT_EQ(note.lost_before, 0U);
  EXPECT_FALSE(session_.PopNote(note));
  EXPECT_EQ(session_.counters().bad_frames, 0U);
}

TEST_F(UsbSessionTest, CountsNotesLostToAFullQueue) {
  Begin();
  constexpr std::size_t kMore = 7;
  for (std::size_t i = 0; i < BaseNotes::kCapacity + kMore; ++i) link_.Give(base_.Frame(FakeBase::KeptFault()));
  BaseNote note;
  for (std::size_t i = 0; i < BaseNotes::kCapacity; ++i) ASSERT_TRUE(session_.PopNote(note)) << i;
  EXPECT_FALSE(session_.PopNote(note));
  link_.Give(base_.Frame(FakeBase::KeptFault()));
  ASSERT_TRUE(session_.PopNote(note));
  EXPECT_EQ(note.lost_before, kMore);
}

TEST_F(UsbSessionTest, MalformedLogIsABadFrame) {
  Begin();
  UsbFrame frame = base_.Frame(wire::Log{});
  frame[wire::kHeaderSize] = 9;  // a level that does not exist
  wire::Header header;
  header.type = wire::MessageType::kLog;
  header.seq = base_.seq++;
  frame.resize(wire::kFrameSizeMax);
  frame.resize(wire::SealFrame(header, wire::PayloadSize<wire::Log>(), frame.data(), frame.size()).size);
  link_.Give(frame);
  BaseNote note;
  EXPECT_FALSE(session_.PopNote(note));
  EXPECT_EQ(session_.counters().bad_frames, 1U);
}

TEST_F(UsbSessionTest, NeverSendsInvalidSetPoints) {
  Begin();
  Live(5);
  const std::size_t before = base_.commands.size();
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 15.01, -15.01, 1e300}) {
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      base::CoilCurrents currents;
      currents.current_A[k] = bad;
      EXPECT_FALSE(session_.Write(currents)) << bad;
    }
  }
  link_.Pump();
  EXPECT_EQ(base_.commands.size(), before);
  EXPECT_EQ(session_.counters().send_failed, 18U);
}

TEST_F(UsbSessionTest, CountsBadFramesAndReadsTheGoodOnes) {
  Begin();
  link_.Give(Bent([](UsbFrame& frame) { frame[30] ^= 4; }));
  link_.Give(Bent([](UsbFrame& frame) { frame.resize(frame.size() - 1); }));
  link_.Give(Bent([](UsbFrame& frame) { frame[6] ^= 1; }));  // payload_len
  link_.Give(Bent([](UsbFrame& frame) { frame[2] = 9; }));   // version
  link_.Give({});
  link_.Give(UsbFrame(512, 7));
  link_.Give(base_.Tick());
  base::HallScan scan;
  ASSERT_EQ(session_.Read(scan, kNow), ReadStatus::kScan);
  EXPECT_EQ(session_.counters().bad_frames, 6U);
  EXPECT_EQ(session_.counters().bad_crc, 1U);
  EXPECT_EQ(session_.counters().received, 1U);
  EXPECT_EQ(session_.counters().missed, 4U) << "the four that were damaged";
}

TEST_F(UsbSessionTest, IgnoresUnsolicitedButRejectsHostOnlyTypes) {
  Begin();
  UsbFrame unknown(64);
  wire::Header header;
  header.type = static_cast<wire::MessageType>(99);
  header.seq = base_.seq;
  unknown.resize(wire::SealFrame(header, 8, unknown.data(), unknown.size()).size);
  link_.Give(unknown);
  link_.Give(base_.Frame(wire::Log{}));
  link_.Give(base_.Frame(wire::Config{}));
  link_.Give(base_.Frame(base_.hello));
  EXPECT_EQ(session_.counters().bad_frames, 0U);
  link_.Give(base_.Frame(wire::Estop{}));
  link_.Give(base_.Frame(wire::Command{}));
  EXPECT_EQ(session_.counters().bad_frames, 2U) << "only a host sends these";
}

TEST_F(UsbSessionTest, RejectsRepeatedAndReorderedFrames) {
  Begin();
  const UsbFrame first = base_.Tick();
  const UsbFrame second = base_.Tick();
  link_.Give(second);
  link_.Give(first);
  link_.Give(second);
  EXPECT_EQ(session_.counters().received, 1U);
  EXPECT_EQ(session_.counters().bad_frames, 2U);
}

TEST_F(UsbSessionTest, SequenceAndStampsIncreaseDespiteLostFrames) {
  Begin();
  base::HallScan before;
  for (int i = 0; i < 40; ++i) {
    if (i % 7 == 0) base_.Frame(wire::Log{});  // lost in transit
    link_.Step();
    base::HallScan scan;
    ASSERT_EQ(session_.Read(scan, kNow), ReadStatus::kScan);
    ASSERT_GT(scan.sequence, before.sequence);
    ASSERT_GE(scan.t_ns, before.t_ns);
    ASSERT_LE(scan.t_ns, base::MonotonicNow_ns());
    before = scan;
  }
  EXPECT_EQ(session_.counters().missed, 6U);
  EXPECT_EQ(session_.counters().bad_frames, 0U);
}

TEST_F(UsbSessionTest, CommandsContinueAfterThePreviousProgramsSequence) {
  base_.telemetry.ack_seq = 40000;
  Begin();
  Live(5);
  const std::uint16_t first = base_.seqs[1];  // after HELLO
  EXPECT_GT(wire::SeqDistance(40000, first), 0);
  for (std::size_t i = 2; i < base_.seqs.size(); ++i) EXPECT_EQ(wire::SeqDistance(base_.seqs[i - 1], base_.seqs[i]), 1);
}

TEST_F(UsbSessionTest, CommandsEchoTheStampOfTheTelemetryRead) {
  Begin();
  Live(3);
  const std::uint64_t answered_us = base_.t_us;
  link_.Give(base_.Tick());  // received, but not read yet
  ASSERT_TRUE(session_.Write({}));
  link_.Pump();
  EXPECT_EQ(base_.commands.back().echo_device_us, answered_us);
  EXPECT_LE(base_.commands.back().host_us, static_cast<std::uint64_t>(base::MonotonicNow_ns() / 1000));
}

TEST_F(UsbSessionTest, LastScanIsDeliveredBeforeGone) {
  Begin();
  link_.Give(base_.Tick());
  session_.OnGone();
  base::HallScan scan;
  EXPECT_EQ(session_.Read(scan, kShort_ns), ReadStatus::kScan);
  EXPECT_EQ(session_.Read(scan, kShort_ns), ReadStatus::kGone);
  EXPECT_EQ(session_.Read(scan, kNow), ReadStatus::kGone);
  EXPECT_FALSE(session_.Write({}));
}

TEST_F(UsbSessionTest, UnpluggingEndsABlockedRead) {
  Begin();
  std::thread unplug([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    session_.OnGone();
  });
  base::HallScan scan;
  EXPECT_EQ(session_.Read(scan, 10'000'000'000), ReadStatus::kGone);
  unplug.join();
}

TEST_F(UsbSessionTest, UnnoticedRestartOfTheBaseIsReportedAsGone) {
  Begin();
  Live(5);
  base_.t_us = 0;
  base_.seq = 0;
  base::HallScan scan;
  for (int i = 0; i < 19; ++i) link_.Give(base_.Tick());
  EXPECT_EQ(session_.Read(scan, kNow), ReadStatus::kTimeout) << "one stray frame is no restart";
  link_.Give(base_.Tick());
  EXPECT_EQ(session_.Read(scan, kNow), ReadStatus::kGone);
}

TEST_F(UsbSessionTest, RejectsImpossibleDeviceTimes) {
  base_.hello.capabilities = wire::kDeviceClockIsHostMonotonic;
  Begin();
  base_.t_us = 1ULL << 63;
  link_.Give(base_.Tick());
  EXPECT_EQ(session_.counters().bad_frames, 1U);
  EXPECT_EQ(session_.counters().received, 0U);
}

TEST_F(UsbSessionTest, HostClockStampsPassUnchanged) {
  base_.hello.capabilities = wire::kDeviceClockIsHostMonotonic;
  Begin();
  base_.t_us = 123'000;
  link_.Give(base_.Tick());
  base::HallScan scan;
  ASSERT_EQ(session_.Read(scan, kNow), ReadStatus::kScan);
  EXPECT_EQ(scan.t_ns, 124'000'000);
}

TEST_F(UsbSessionTest, CountsInterruptedAndFailedTransfers) {
  Begin();
  session_.OnInterrupted();
  session_.OnInterrupted();
  session_.OnSendFailed();
  EXPECT_EQ(session_.counters().interrupted, 2U);
  EXPECT_EQ(session_.counters().send_failed, 1U);
}

}  // namespace test_device_usb_session
}  // namespace omni::device
