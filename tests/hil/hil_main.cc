// omni_hil [options] -- PROGRAM ARGUMENTS: a base without hardware. The plant, the control core and USB are emulated;
// PROGRAM (omnid --device usb) is what people run. Example:
//   omni_hil --script scenes/extrusion.hand.json --record truth.csv -- omnid --device usb
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "service/config/device_file.h"
#include "service/config/twin_file.h"
#include "service/sim/twin.h"
#include "tests/hil/hil_run.h"
#include "tests/hil/usb_emulator.h"

namespace {

using omni::hil::HilOptions;

int Fail(const std::string& message) {
  std::fprintf(stderr, "omni_hil: %s\n", message.c_str());
  return 1;
}

int ParseAndRun(const std::vector<std::string>& own, std::vector<std::string> program) {
  HilOptions options;
  options.program = std::move(program);
  options.plant.truth = omni::config::DefaultTwin();
  std::string script;
  bool virtual_time = false;
  CLI::App app{"omni_hil: a simulated base with its firmware behind an emulated USB plug, and a program on it"};
  app.add_option("--board", options.board, "where the control core runs: host, qemu")->capture_default_str();
  app.add_option("--script", script, "hand script (.json); default: no pen");
  app.add_option("--seed", options.plant.seed, "of noise and imperfections")->capture_default_str();
  app.add_option("--record", options.record_path, "CSV file of the true pose and the currents");
  app.add_option("--summary", options.summary_path, "JSON file (default: standard output)");
  app.add_option("--scenario", options.scenario, "what goes wrong");
  app.add_option("--contact-timeout", options.contact_timeout_s, "seconds a scenario waits for the pen's contact")
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "of device time (default: until the program ends)");
  app.add_flag("--virtual", virtual_time, "virtual time: a device tick per message of the program, as fast as it can");
  std::vector<std::string> reversed(own.rbegin(), own.rend());
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  }
  options.paced = !virtual_time;
  if (!script.empty()) {
    auto loaded = omni::sim::LoadHandScript(script);
    if (!loaded) return Fail(loaded.error());
    options.plant.script = *loaded;
  }
  return omni::hil::RunHil(omni::config::DefaultDevice(), options);
}

}  // namespace

int main(int argc, char** argv) {
  const omni::base::Status mocked = omni::hil::EnterMockEnvironment(argv);
  if (!mocked) return Fail(mocked.error());
  std::vector<std::string> own, program;
  bool ours = true;
  for (int i = 1; i < argc; ++i) {
    if (ours && std::string(argv[i]) == "--") {
      ours = false;
    } else {
      (ours ? own : program).emplace_back(argv[i]);
    }
  }
  try {
    return ParseAndRun(own, program);
  } catch (const std::exception& error) {
    return Fail(error.what());
  }
}
