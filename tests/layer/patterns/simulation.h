// The world around a program: the service and the runtime's controllers, moved by the test, which knows what is in it.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tests/layer/patterns/scenario.h"
#include "tests/layer/support/app.h"

namespace omni::test::patterns {

enum class Who { kNobody, kPen, kController };

class Simulation {
 public:
  // With controllers of this profile; the service prefers `preferred` for the pen, if it is not empty.
  explicit Simulation(const char* controllers, std::string preferred = {});

  void Enter(const World& world);
  const World& world() const { return world_; }
  bool HasController(int hand) const { return world_.controller[static_cast<std::size_t>(hand)]; }

  // Who has that hand, for any program.
  Who Truth(int hand) const;
  bool pen_tracked() const { return world_.pen != PenState::kLost; }
  // Where it is in this base space, now or before the recentring: the tip, or else the grip.
  XrVector3f Place(Who who, int hand, XrReferenceSpaceType base, bool tip) const;
  XrVector3f PlaceBefore(Who who, int hand, XrReferenceSpaceType base, bool tip) const;

  void PressPen(bool pressed);
  void PressController(int hand, bool pressed) const;
  std::size_t pen_vibrations() const;
  // Publishes the pen's samples up to now.
  void Fill() const;

 private:
  void EnterService(const World& world);

  const char* const controllers_;
  const std::string preferred_;
  World world_;
  int hand_ = -1;         // that the service has named
  std::size_t past_ = 0;  // vibrations of the services before this one
  std::unique_ptr<FakeService> service_;
};

}  // namespace omni::test::patterns
