// The same core, compiled for the host and running on the emulated Cortex-M7, with the same requests: every output and
// every byte of every frame must be the same.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstring>

#include "firmware/core/lockstep_board.h"
#include "firmware/wire/frame.h"
#include "tests/hil/board/qemu_board.h"
#include "tests/hil/board/session.h"
#include "tests/hil/board/tools.h"
#include "tests/support/drill.h"

namespace omni::hil {
namespace {

using namespace firmware;

constexpr int kSteps = 100'000;         // 25 s of device time
constexpr int kTimeout_ms = 1'400'000;  // it only ends what hangs

std::uint32_t Hash(std::uint32_t before, const LockstepAnswer& answer) {
  std::uint8_t bytes[4 + sizeof answer];
  std::memcpy(bytes, &before, 4);
  std::memcpy(bytes + 4, &answer, sizeof answer);
  return wire::Crc32c(bytes, sizeof bytes);
}

bool IsSame(const LockstepAnswer& a, const LockstepAnswer& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// The host in the loop is rough, to cover idle, armed and fault states, refusals and answers of all kinds.
TEST(Lockstep, HostAndTargetAgreeInEveryBit) {
  OMNI_NEEDS_BOARD();
  const auto target = QemuBoard::Start({});
  ASSERT_TRUE(target.ok()) << target.error();
  FaultRecord record;
  LockstepBoard host(Settings{}, ResetCause::kPower, 0, record);
  Session session(Session::Manner::kRough, 1);
  LockstepAnswer on_host;
  std::uint32_t host_hash = 0, target_hash = 0;
  int in_state[5] = {};
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < kSteps; ++i) {
    const LockstepRequest& request = session.Next(on_host);
    host.HandleRequest(request, on_host);
    const auto on_target = (*target)->Step(request);
    ASSERT_TRUE(on_target.ok()) << "step " << i << ": " << on_target.error();
    host_hash = Hash(host_hash, on_host);
    target_hash = Hash(target_hash, *on_target);
    ASSERT_TRUE(IsSame(on_host, *on_target)) << "step " << i << ", state " << static_cast<int>(host.core().state());
    ++in_state[static_cast<int>(host.core().state())];
  }
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("%d steps: hash %08x on the host, %08x on the target; %.0f steps/s, %.1f of real time\n", kSteps,
              host_hash, target_hash, kSteps / wall_s, kSteps * 1e-6 * kStepPeriod_us / wall_s);
  std::printf("steps in self-test %d, idle %d, armed %d, fault %d; armed %d times, %d frames of telemetry\n",
              in_state[1], in_state[2], in_state[3], in_state[4], session.times_armed(), session.telemetries());
  EXPECT_EQ(host_hash, target_hash);
  // Where the core was: a run that never armed would agree too.
  EXPECT_GT(in_state[3], kSteps / 4);
  EXPECT_GT(in_state[4] + in_state[2], 100);
  EXPECT_GE(session.times_armed(), 3);
  const auto end = (*target)->Exit(0);
  ASSERT_TRUE(end.ok()) << end.error();
  EXPECT_EQ(end->status, 0);
}

TEST(Lockstep, DrillChecksumMatchesTheHost) {
  OMNI_NEEDS_BOARD();
  const auto run = RunImage({"mps2_drill", {std::to_string(kSteps)}}, kTimeout_ms);
  ASSERT_TRUE(run.ok()) << run.error();
  EXPECT_EQ(run->status, 0);
  int steps = 0;
  unsigned checksum = 0;
  ASSERT_EQ(std::sscanf(run->output.c_str(), "drill %d %x", &steps, &checksum), 2) << run->output;
  EXPECT_EQ(steps, kSteps);
  const std::uint32_t on_host = DrillChecksum(kSteps);
  std::printf("drill of %d steps: %08x on the host, %08x on the target\n", kSteps, on_host, checksum);
  EXPECT_EQ(checksum, on_host);
  EXPECT_NE(on_host, DrillChecksum(kSteps - 1)) << "every step counts";
}

// The core's answer to a FAULT request; fault = 0: nothing is recorded.
base::Result<wire::FaultEvent> RequestRecord(QemuBoard& target, Session& session) {
  LockstepRequest request;
  request.frames[0] = Question(wire::MessageType::kFault, 1);
  for (int i = 0; i < 40; ++i) {
    const auto answer = target.Step(request);
    if (!answer) return base::Error{answer.error()};
    request = session.Next(*answer);
    for (const LockstepFrame& frame : answer->frames) {
      wire::FrameView view;
      wire::FaultEvent event;
      if (frame.size == 0 || wire::OpenFrame(frame.bytes, frame.size, view) != wire::Status::kOk) continue;
      if (wire::Decode(view, event) == wire::Status::kOk && event.after_reset != 0) return event;
    }
  }
  return base::Error{"no answer to FAULT"};
}

// An emergency stop, then the machine resets: start-up runs again, memory of the core is new, the record is still
// there.
TEST(Lockstep, ResetKeepsTheFaultRecord) {
  OMNI_NEEDS_BOARD();
  const auto started = QemuBoard::Start({});
  ASSERT_TRUE(started.ok()) << started.error();
  QemuBoard& target = **started;
  LockstepAnswer answer;
  Session before(Session::Manner::kIdle, 2);
  for (int i = 0; i < 8000; ++i) {
    LockstepRequest request = before.Next(answer);
    if (i > 4000) request.inputs.emergency_stop = 1;
    const auto stepped = target.Step(request);
    ASSERT_TRUE(stepped.ok()) << stepped.error();
    answer = *stepped;
  }
  EXPECT_NE(before.telemetry().faults & wire::kFaultEmergencyStop, 0U);

  const base::Status reset = target.Reset(ResetCause::kSoftware);
  ASSERT_TRUE(reset.ok()) << reset.error();
  Session after(Session::Manner::kIdle, 3);
  const auto event = RequestRecord(target, after);
  ASSERT_TRUE(event.ok()) << event.error();
  EXPECT_EQ(event->fault, wire::kFaultEmergencyStop);
  EXPECT_EQ(after.telemetry().faults & wire::kFaultEmergencyStop, 0U) << "the core itself is a new one";

  const auto other = QemuBoard::Start({});
  ASSERT_TRUE(other.ok()) << other.error();
  Session fresh(Session::Manner::kIdle, 4);
  const auto none = RequestRecord(**other, fresh);
  ASSERT_TRUE(none.ok()) << none.error();
  EXPECT_EQ(none->fault, 0U) << "power-on has no record";
}

}  // namespace
}  // namespace omni::hil
