#include "service/tools/common/command_line.h"

#include <exception>
#include <string>

namespace omni::tools {
namespace {

// Commands that moved to omni-bench.
void AddMoved(Command& app, const std::string& name, const std::string& now) {
  app.AddHidden(name).SetAction([name, now] {
    return FailUsage("omni " + name,
                     "moved to `" + now +
                         "`, a separate program in the source tree: cmake -S tests/bench -B build/bench && " +
                         "cmake --build build/bench --target omni-bench; build/bench/bin/" + now);
  });
}

}  // namespace

void AddSocket(Command& command, std::string& socket) {
  command.Add("--socket", socket, "control socket (default: $OMNI_SOCKET, else the user's)");
}

void AddUp(Command& command, std::string& up) {
  command.Add("--up", up, "the file's axis that is up: y, as glTF says, or z").OneOf({"y", "z"}).ShowDefault();
}

void AddCommands(console::Program& omni) {
  omni.RequireCommand();
#define OMNI_ADD(name) Add##name(omni);
  OMNI_COMMANDS(OMNI_ADD)
#undef OMNI_ADD
}

int RunCommandLine(int argc, const char* const* argv) {
  try {
    console::Program omni("omni", kOmniAbout, OMNI_VERSION);
    AddCommands(omni);
    AddRehearseController(omni);
    AddMoved(omni, "bench", "omni-bench");
    AddMoved(omni, "paper", "omni-bench paper");
    return omni.Parse(argc, argv).value_or(kExitOk);
  } catch (const std::exception& error) {
    return Fail("omni", error.what());
  }
}

}  // namespace omni::tools
