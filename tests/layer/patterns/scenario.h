// What happens around a program, as rows: who is there, step by step. What it then has to see follows from that alone.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace omni::test::patterns {

enum class PenState { kAway, kHeld, kDocked, kLost };  // lost: has a pose, not tracked any more

struct World {
  bool service = true;
  PenState pen = PenState::kHeld;
  int hand = 1;  // of the pen
  std::array<bool, 2> controller{true, true};
  bool focused = true;
  bool recentred = false;
};
enum class Restart { kNone, kSession, kInstance };
struct Step {
  World world;
  Restart restart = Restart::kNone;  // in this world, before anything is judged
  bool pressed = false;              // the pen is pressed until this step comes
};
struct Scenario {
  const char* name;
  const char* id;
  const char* what;         // for the page
  std::vector<Step> steps;  // the first is there before the program starts
};

// For a pen of hand `hand`.
std::vector<Scenario> Scenarios(int hand);

}  // namespace omni::test::patterns
