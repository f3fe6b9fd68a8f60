#include "tests/layer/patterns/scenario.h"

#include <utility>

namespace omni::test::patterns {
namespace {

// The other hand always has its controller.
World With(int hand, PenState pen, bool controller = true) {
  World world;
  world.pen = pen;
  world.hand = hand;
  world.controller[static_cast<std::size_t>(hand)] = controller;
  return world;
}

template <class Change>
World Changed(World world, Change change) {
  change(world);
  return world;
}

}  // namespace

std::vector<Scenario> Scenarios(int hand) {
  using enum PenState;
  const World both = With(hand, kHeld), none = With(hand, kAway), alone = With(hand, kHeld, false);
  const World empty = With(hand, kAway, false);
  const World without_service = Changed(both, [](World& w) { w.service = false; });
  const World bare = Changed(empty, [](World& w) { w.service = false; });
  const World other_hand = Changed(both, [](World& w) { w.hand = 1 - w.hand; });
  const World moved = Changed(both, [](World& w) { w.recentred = true; });
  const World unfocused = Changed(both, [](World& w) { w.focused = false; });
  const World unfocused_none = Changed(none, [](World& w) { w.focused = false; });
  return {
      {"pen first",
       "PenFirst",
       "the pen is there before the program, the controller of its hand comes later",
       {{alone}, {both}, {none}}},
      {"controller first",
       "ControllerFirst",
       "the controller is there before the program, the pen comes later",
       {{none}, {both}, {none}, {both}}},
      {"late",
       "Late",
       "the program starts without the service and with an empty hand; service and pen come later",
       {{bare}, {empty}, {alone}, {both}}},
      {"put down",
       "PutDown",
       "the pen is docked and taken up; with no controller there, it keeps its hand",
       {{both}, {With(hand, kDocked)}, {both}, {With(hand, kDocked, false)}, {alone}}},
      {"gone",
       "Gone",
       "the pen is lost: the controller has the hand after a second, without one the pen keeps it",
       {{both}, {With(hand, kLost)}, {both}, {none}, {alone}, {With(hand, kLost, false)}, {empty}}},
      {"hand switched", "HandSwitched", "the pen goes to the other hand, and back", {{both}, {other_hand}, {both}}},
      {"recentre", "Recentre", "the origin of LOCAL moves and turns while the pen is held", {{both}, {moved}}},
      {"focus lost",
       "FocusLost",
       "the pen comes, goes and stays while the program has no focus",
       {{both}, {unfocused, Restart::kNone, true}, {both}, {unfocused}, {unfocused_none}, {none}, {unfocused}, {both}}},
      {"session restarted",
       "SessionRestarted",
       "the program ends its session and begins another one, twice",
       {{both}, {both, Restart::kSession}, {none}, {none, Restart::kSession}, {both}}},
      {"instance restarted",
       "InstanceRestarted",
       "the program destroys its instance and makes another one, twice",
       {{both}, {both, Restart::kInstance}, {none}, {none, Restart::kInstance}, {both}}},
      {"omnid killed",
       "OmnidKilled",
       "the service ends and returns, with and without a controller in the hand",
       {{both}, {without_service, Restart::kNone, true}, {both}, {alone}, {bare, Restart::kNone, true}, {alone}}},
  };
}

}  // namespace omni::test::patterns
