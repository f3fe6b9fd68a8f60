// A host and a nominal base around a core in lockstep: the requests of a realistic session. It boots, arms in two
// steps, follows currents, and (kRough) includes everything that can go wrong on a wire. The loop is closed: requests
// depend on the answers before. All of it follows from the seed.
#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "firmware/core/link/settings.h"
#include "firmware/core/lockstep_board.h"

namespace omni::hil {

// Coils with resistance, inductance and heat, sensors without fault; what a core reads after each step.
class NominalBase {
 public:
  explicit NominalBase(std::uint64_t seed) : random_(seed) {}
  const firmware::Inputs& Step(const firmware::Outputs& outputs);
  firmware::Inputs& inputs() { return inputs_; }

 private:
  void StepCoil(std::size_t k, const firmware::Outputs& outputs);
  void StepHall(std::size_t i, bool test_field);

  std::mt19937_64 random_;
  const firmware::Settings settings_;
  firmware::Inputs inputs_;
  std::array<double, wire::kCoils> current_A_{};
  std::array<double, wire::kCoils> copper_C_{24, 24, 24};
  double fan_rpm_ = 0;
  std::uint64_t step_ = 0;
};

// HELLO and FAULT without a payload are requests.
firmware::LockstepFrame Question(wire::MessageType type, std::uint16_t seq);

class Session {
 public:
  enum class Manner {
    kIdle,   // never arms
    kPlain,  // arms, drives
    kRough,  // and corrupts, repeats, reorders, withholds frames, falls silent, opens the emergency switch
  };
  Session(Manner manner, std::uint64_t seed) : manner_(manner), random_(seed), base_(seed + 1) {}

  // `previous`: the answer to the request before; at first an empty one.
  const firmware::LockstepRequest& Next(const firmware::LockstepAnswer& previous);

  // Of the newest telemetry.
  const wire::Telemetry& telemetry() const { return telemetry_; }
  int telemetries() const { return telemetries_; }
  int times_armed() const { return times_armed_; }

 private:
  void Read(const firmware::LockstepFrame& frame);
  void Speak();
  void SpeakRoughly();
  template <class Message>
  void Send(const Message& message);
  wire::Command CommandNow();

  const Manner manner_;
  std::mt19937_64 random_;
  NominalBase base_;
  firmware::LockstepRequest request_;
  int frames_ = 0;  // in request_
  firmware::LockstepFrame kept_;
  wire::Telemetry telemetry_;
  wire::Arm challenge_;
  std::uint64_t now_us_ = 0;
  std::uint64_t silent_until_us_ = 0, open_until_us_ = 0;
  std::uint16_t seq_ = 0;
  int telemetries_ = 0, times_armed_ = 0;
};

}  // namespace omni::hil
