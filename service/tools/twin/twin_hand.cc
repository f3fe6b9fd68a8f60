// omni twin hand: acts in place of a person at the pen of the digital twin. Perceives only what omnid publishes to its
// clients, and moves only the aim of the simulated hand.
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "service/base/clock.h"
#include "service/client/dial.h"
#include "service/config/files/device_file.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/terminal.h"
#include "service/tools/hand/person.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {
namespace {

constexpr const char* kHandCommand = "omni twin hand";
constexpr auto kHandPeriod = std::chrono::milliseconds(8);
constexpr double kReachForTouches_m = 0.010;  // from the z axis: where the device is strong
constexpr int kTouchPlaces = 8;

struct HandArguments {
  std::string scene, hand, socket, up = "y";
  double patience_s = 90;
  bool fit = false, touch_all = false;
};

protocol::HandAim MessageOf(const sim::HandAim& aim) {
  const base::Vec3 &p = aim.tip_base_m, &u = aim.axis_base;
  return {.present = aim.present ? 1U : 0U, .tip_base_m = {p.x, p.y, p.z}, .axis_base = {u.x, u.y, u.z}};
}

// Until the task is done, omnid is gone, or the time is over.
int LeadHand(const HandArguments& arguments, const Intent& intent) {
  const EndSignals signals;
  Eyes eyes(arguments.socket, {.soft = intent.soft, .clay = intent.clay});
  client::HandLink hand(arguments.hand);
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  const auto elapsed_s = [&] { return static_cast<double>(base::MonotonicNow_ns() - begin_ns) * 1e-9; };
  bool was_connected = false;
  while (!intent.task->done() && !EndSignals::asked()) {
    if (elapsed_s() > arguments.patience_s) {
      if (!was_connected) break;
      char after[32];
      std::snprintf(after, sizeof(after), " after %.0f s", arguments.patience_s);
      return Fail(kHandCommand, intent.task->Summary() + after);
    }
    const Perceived seen = eyes.Observe(base::MonotonicNow_ns());
    if (was_connected && !eyes.connected())
      return Fail(kHandCommand, "lost the connection to omnid: " + intent.task->Summary());
    was_connected = eyes.connected();
    const auto aim = intent.task->NextAim(seen);
    if (aim && hand.Connect()) hand.Send(MessageOf(*aim));
    if (aim && !hand.connected()) return Fail(kHandCommand, hand.problem());
    std::this_thread::sleep_for(kHandPeriod);
  }
  if (!was_connected) {
    std::fprintf(stderr, "%s: %s\n", kHandCommand, eyes.problem().c_str());
    return kExitNoService;
  }
  if (!intent.task->done()) return Fail(kHandCommand, "interrupted: " + intent.task->Summary());
  std::printf("%s (%.1f s)\n", intent.task->Summary().c_str(), elapsed_s());
  return kExitOk;
}

int TwinHand(const HandArguments& arguments) {
  const base::Result<std::string> found = FindScene(arguments.scene);
  if (!found.ok()) return Fail(kHandCommand, found.error());
  const std::string& path = *found;
  const auto loaded = LoadScene(path, LoadOptionsOf(arguments));
  if (!loaded.ok()) return Fail(kHandCommand, loaded.error());
  const auto intent = IntentFor(
      loaded->scene,
      {.hull_radius_m = config::DefaultDevice().hull_radius_m, .reach_m = kReachForTouches_m, .places = kTouchPlaces});
  if (!intent.ok()) return Fail(kHandCommand, path + ": " + intent.error());
  return LeadHand(arguments, *intent);
}

}  // namespace

void AddTwinHand(Command& twin) {
  auto arguments = std::make_shared<HandArguments>();
  Command hand = twin.AddCommand(
      "hand", "move the twin's pen like a person: drive, sculpt or press by what omnid publishes to applications");
  hand.Add("scene", arguments->scene, "the scene that the application shows: a .glb or .gltf file, or a shipped one")
      .Required();
  hand.Add("--hand", arguments->hand, "the socket of `omnid --device twin --twin-hand`").Required();
  hand.Add("--patience", arguments->patience_s, "give up after this many seconds").Range(1.0, 3600.0).ShowDefault();
  AddSocket(hand, arguments->socket);
  AddUp(hand, arguments->up);
  hand.Add("--fit", arguments->fit, "the application's scene is scaled and moved into reach");
  hand.Add("--touch-all", arguments->touch_all,
           "the scene has no haptic tags and is touchable everywhere (--fit does too)");
  hand.SetAction(arguments, TwinHand);
}

}  // namespace omni::tools
