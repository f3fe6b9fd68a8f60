// The handshake by itself: times and orders that a whole session does not show.
#include <gtest/gtest.h>

#include "service/device/commands.h"

namespace omni::device {
namespace test_device_arming {

wire::Telemetry Idle() {
  wire::Telemetry telemetry;
  telemetry.state = wire::State::kIdle;
  telemetry.faults = wire::kFaultNotArmed;
  return telemetry;
}

wire::Arm Answer(wire::ArmStep step, std::uint32_t nonce = 0) {
  wire::Arm arm;
  arm.step = step;
  arm.nonce = nonce;
  return arm;
}

TEST(Arming, SendsOneRequestPerAttempt) {
  Arming arming;
  wire::Arm sent;
  EXPECT_FALSE(arming.NextToSend(0, sent)) << "nothing is known of the base yet";
  arming.OnTelemetry(Idle(), 0);
  ASSERT_TRUE(arming.NextToSend(0, sent));
  EXPECT_EQ(sent.step, wire::ArmStep::kRequest);
  EXPECT_FALSE(arming.NextToSend(0, sent));
  arming.OnTelemetry(Idle(), Arming::kAnswer_ns);
  EXPECT_FALSE(arming.NextToSend(Arming::kAnswer_ns, sent)) << "the answer may still come";
  arming.OnTelemetry(Idle(), Arming::kAnswer_ns + 1);
  EXPECT_TRUE(arming.NextToSend(Arming::kAnswer_ns + 1, sent));
  EXPECT_EQ(sent.step, wire::ArmStep::kRequest);
}

TEST(Arming, ConfirmsOnceWithTheNonceOfTheChallenge) {
  Arming arming;
  wire::Arm sent;
  arming.OnTelemetry(Idle(), 0);
  ASSERT_TRUE(arming.NextToSend(0, sent));
  ASSERT_TRUE(arming.OnArm(Answer(wire::ArmStep::kChallenge, 99), 1));
  EXPECT_FALSE(arming.OnArm(Answer(wire::ArmStep::kChallenge, 98), 1)) << "a second one is unsolicited";
  ASSERT_TRUE(arming.NextToSend(2, sent));
  EXPECT_EQ(sent.step, wire::ArmStep::kConfirm);
  EXPECT_EQ(sent.nonce, 99U);
  EXPECT_TRUE(arming.OnArm(Answer(wire::ArmStep::kArmed), 3));
  EXPECT_FALSE(arming.armed()) << "only telemetry confirms that";
  wire::Telemetry armed = Idle();
  armed.state = wire::State::kArmed;
  armed.faults = 0;
  arming.OnTelemetry(armed, 4);
  EXPECT_TRUE(arming.armed());
  EXPECT_FALSE(arming.NextToSend(4, sent));
}

TEST(Arming, RejectsUnsolicitedAnswers) {
  for (const wire::ArmStep step : {wire::ArmStep::kRequest, wire::ArmStep::kChallenge, wire::ArmStep::kConfirm,
                                   wire::ArmStep::kArmed, wire::ArmStep::kRefused}) {
    Arming arming;
    EXPECT_FALSE(arming.OnArm(Answer(step), 0));
    EXPECT_FALSE(arming.held());
  }
}

TEST(Arming, IsNotArmedWhileTelemetryShowsAFault) {
  Arming arming;
  wire::Telemetry telemetry = Idle();
  telemetry.state = wire::State::kArmed;
  telemetry.faults = wire::kFaultFan;
  arming.OnTelemetry(telemetry, 0);
  EXPECT_FALSE(arming.armed());
  EXPECT_TRUE(arming.held());
}

TEST(Arming, RefusalForARunningSelfTestIsTemporary) {
  Arming arming;
  wire::Arm sent;
  arming.OnTelemetry(Idle(), 0);
  ASSERT_TRUE(arming.NextToSend(0, sent));
  wire::Arm refusal = Answer(wire::ArmStep::kRefused);
  refusal.faults = wire::kFaultSelfTest;
  ASSERT_TRUE(arming.OnArm(refusal, 0));
  EXPECT_FALSE(arming.held());
  wire::Telemetry failed = Idle();
  failed.faults = wire::kFaultSelfTest;
  arming.OnTelemetry(failed, 1);
  EXPECT_TRUE(arming.held()) << "telemetry reports that it failed";
}

TEST(Arming, RetriesOnlyAfterThePause) {
  Arming arming;
  wire::Arm sent;
  arming.OnTelemetry(Idle(), 0);
  ASSERT_TRUE(arming.NextToSend(0, sent));
  ASSERT_TRUE(arming.OnArm(Answer(wire::ArmStep::kRefused), 0));
  arming.OnTelemetry(Idle(), Arming::kPause_ns - 1);
  EXPECT_FALSE(arming.NextToSend(Arming::kPause_ns - 1, sent));
  arming.OnTelemetry(Idle(), Arming::kPause_ns);
  EXPECT_TRUE(arming.NextToSend(Arming::kPause_ns, sent));
}

}  // namespace test_device_arming
}  // namespace omni::device
