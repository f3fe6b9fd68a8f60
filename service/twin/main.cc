// omni-twin: the digital twin, a simulated base with pen and hand, as a process of its own behind an inherited socket.
// omnid --device twin starts it; nobody else has to.
#include <fcntl.h>

#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/console/command.h"
#include "service/sim/twin/twin.h"
#include "service/twin/socket_guide.h"

namespace omni::twin {
namespace {

constexpr const char* kProgram = "omni-twin";

int Fail(const std::string& message) { return console::Fail(kProgram, message); }

struct ServeArguments {
  int fd = -1;
  std::uint64_t seed = 1;
  std::string script;
  std::string hand;
  std::string record;
  std::string device;
  std::string twin;
  double linger_s = 0.2;  // coils are at zero 50 ms after the host is gone; omnid waits for the end
};

// Without a script the pen comes down over the base and circles there, for as long as the twin runs.
sim::HandScript IdleHand() {
  constexpr double kHeight_m = 0.06;
  constexpr double kRadius_m = 0.01;
  sim::HandScript script;
  script.name = "idle";
  script.repeat = true;
  script.waypoints = {{.duration_s = 0, .tip_base_m = {0, 0, 0.09}},
                      {.duration_s = 1, .tip_base_m = {kRadius_m, 0, kHeight_m}},
                      {.duration_s = 1, .tip_base_m = {0, kRadius_m, kHeight_m}},
                      {.duration_s = 1, .tip_base_m = {-kRadius_m, 0, kHeight_m}},
                      {.duration_s = 1, .tip_base_m = {0, -kRadius_m, kHeight_m}},
                      {.duration_s = 1, .tip_base_m = {0, 0, 0.09}}};
  return script;
}

int Serve(const ServeArguments& arguments) {
  if (::fcntl(arguments.fd, F_GETFD) < 0) {
    return Fail("--fd " + std::to_string(arguments.fd) +
                " is not an open descriptor; omnid starts the twin itself: run `omnid --device twin`");
  }
  base::DeviceGeometry device = config::DefaultDevice();
  if (!arguments.device.empty()) {
    base::Result<base::DeviceGeometry> loaded = config::LoadDeviceFile(arguments.device);
    if (!loaded.ok()) return Fail(loaded.error());
    device = *loaded;
  }
  const base::Result<base::TruthParameters> truth = config::FindTwin(arguments.twin);
  if (!truth.ok()) return Fail(truth.error());
  sim::TwinOptions options{
      .seed = arguments.seed, .script = IdleHand(), .truth = *truth, .recording_path = arguments.record};
  if (!arguments.script.empty()) {
    base::Result<sim::HandScript> loaded = sim::LoadHandScript(arguments.script);
    if (!loaded.ok()) return Fail(loaded.error());
    options.script = *loaded;
  }
  if (!arguments.hand.empty()) {
    auto listener = ipc::HandListener::Open(arguments.hand);
    if (!listener.ok()) return Fail(listener.error());
    options.guide = std::make_shared<SocketGuide>(std::move(*listener));
  }
  return sim::ServeTwin(device, options, arguments.fd, arguments.linger_s);
}

void AddOptions(console::Command& app, ServeArguments& arguments) {
  app.Add("--fd", arguments.fd, "inherited seqpacket socket that carries the frames").Required();
  app.Add("--seed", arguments.seed, "of noise and imperfections").ShowDefault();
  app.Add("--script", arguments.script, "hand script (.json); default: circles above the base");
  app.Add("--hand", arguments.hand,
          "socket on which a program leads the hand (`omni twin hand`); of the script only the first waypoint "
          "and the hand itself count then");
  app.Add("--record", arguments.record, "CSV file of the true pose and the currents");
  app.Add("--linger", arguments.linger_s, "seconds to go on after the host is gone").Range(0.0, 3600.0).ShowDefault();
  app.Add("--device", arguments.device, "geometry and limits (.toml); default: the built-in omni.toml");
  app.Add("--twin", arguments.twin, config::kTwinHelp);
}

int Run(int argc, const char* const* argv) {
  console::Program app(kProgram,
                       "omni-twin: the digital twin, a simulated base, pen and hand; started by omnid --device twin",
                       OMNI_VERSION);
  ServeArguments arguments;
  AddOptions(app, arguments);
  if (const auto ended = app.Parse(argc, argv)) return *ended;
  return Serve(arguments);
}

}  // namespace
}  // namespace omni::twin

int main(int argc, char** argv) {
  try {
    return omni::twin::Run(argc, argv);
  } catch (const std::exception& error) {
    return omni::twin::Fail(error.what());
  }
}
