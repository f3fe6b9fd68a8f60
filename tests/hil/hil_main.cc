// omni_hil [options] -- PROGRAM ARGUMENTS [-- APPLICATION ARGUMENTS]...: a base without hardware. The plant, the
// control core and USB are emulated; PROGRAM (omnid --device usb) is unmodified, and time is the device's.
// Example:
//   omni_hil --script scenes/extrusion.hand.json --record truth.csv -- omnid --device usb
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/console/command.h"
#include "service/sim/twin/twin.h"
#include "tests/hil/hil_run.h"
#include "tests/hil/scenario.h"
#include "tests/hil/usb/usb_emulator.h"

namespace {

using omni::hil::HilOptions;

int Fail(const std::string& message) {
  std::fprintf(stderr, "omni_hil: %s\n", message.c_str());
  return 1;
}

int ParseAndRun(const std::vector<std::string>& own, std::vector<std::vector<std::string>> programs) {
  HilOptions options;
  options.programs = std::move(programs);
  std::string script, twin;
  bool fast = false;
  omni::console::Program app(
      "omni_hil", "omni_hil: a simulated base with its firmware behind an emulated USB plug, and programs on it");
  app.Add("--board", options.board, "where the control core runs").OneOf({"host", "qemu"}).ShowDefault();
  app.Add("--script", script, "hand script (.json); default: no pen");
  app.Add(
      "--hand", options.hand_path,
      "socket on which a program leads the hand (omni twin hand); the script then provides only the first waypoint and "
      "the hand itself");
  app.Add("--seed", options.plant.seed, "of noise and imperfections").ShowDefault();
  const auto which = app.Add("--twin", twin, omni::config::kTwinHelp);
  app.AddShort("--ideal", twin, omni::config::kIdeal, omni::config::kIdealHelp).Excludes(which);
  app.Add("--record", options.record_path, "CSV file of the true pose and the currents");
  app.Add("--summary", options.summary_path, "JSON file (default: standard output)");
  std::vector<std::string> scenarios;
  for (const omni::hil::Scenario& scenario : omni::hil::AllScenarios()) scenarios.emplace_back(scenario.name);
  app.Add("--scenario", options.scenario, "what goes wrong in this run").OneOf(scenarios);
  app.Add("--contact-timeout", options.contact_timeout_s, "seconds a scenario waits for the pen's contact")
      .ShowDefault();
  app.Add("--seconds", options.seconds, "of device time (default: until the program ends)");
  app.Add("--fast", fast, "as fast as the programs can (default: not faster than the wall clock)");
  app.Add("--clock", options.clock_path,
          "file of the virtual clock: programs started with OMNI_HIL_CLOCK=FILE and "
          "LD_PRELOAD=libomni_hil_clock.so join in");
  if (const auto ended = app.Parse(own)) return *ended;
  if (options.programs.empty()) {
    Fail("no program to start: give one after --, as in omni_hil -- omnid --device usb");
    return omni::console::kExitUsage;
  }
  options.paced = !fast;
  const auto truth = omni::config::FindTwin(twin);
  if (!truth.ok()) return Fail(truth.error());
  options.plant.truth = *truth;
  if (!script.empty()) {
    auto loaded = omni::sim::LoadHandScript(script);
    if (!loaded) return Fail(loaded.error());
    options.plant.script = *loaded;
  }
  options.plant.led = !options.hand_path.empty();
  return omni::hil::RunHil(omni::config::DefaultDevice(), options);
}

}  // namespace

int main(int argc, char** argv) {
  const omni::base::Status mocked = omni::hil::EnterMockEnvironment(argv);
  if (!mocked) return Fail(mocked.error());
  std::vector<std::string> own;
  std::vector<std::vector<std::string>> programs;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--") {
      programs.emplace_back();
    } else {
      (programs.empty() ? own : programs.back()).emplace_back(argv[i]);
    }
  }
  try {
    return ParseAndRun(own, std::move(programs));
  } catch (const std::exception& error) {
    return Fail(error.what());
  }
}
