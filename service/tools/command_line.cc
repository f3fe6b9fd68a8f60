#include "service/tools/command_line.h"

#include <exception>
#include <string>

#include <CLI/CLI.hpp>

#include "service/tools/commands.h"

namespace omni::tools {
namespace {

// One row a subcommand.
struct CommandEntry {
  void (*add)(CLI::App& app);
};
constexpr CommandEntry kCommands[] = {{AddStatus}, {AddWatch},    {AddDoctor},    {AddScene},  {AddTwin},
                                      {AddReport}, {AddTrack},    {AddCalibrate}, {AddDevice}, {AddRecord},
                                      {AddReplay}, {AddSurfaces}, {AddLayer},     {AddAlign}};

constexpr const char* kAbout = "omni: see and check the Omni haptic base, its service and its scenes";

// What left for omni-bench.
void AddMoved(CLI::App& app, const std::string& name, const std::string& now) {
  CLI::App* moved = app.add_subcommand(name)->group("")->allow_extras();
  moved->set_help_flag();
  moved->callback([name, now] {
    Fail("omni " + name, "it is `" + now +
                             "` now, a program of its own in the source tree: cmake --preset release && " +
                             "cmake --build --preset release --target omni-bench; build/release/bin/" + now);
    throw CLI::RuntimeError(kExitUsage);
  });
}

}  // namespace

int RunCommandLine(int argc, const char* const* argv) {
  try {
    CLI::App app{kAbout, "omni"};
    app.require_subcommand(1);
    app.footer(console::kExitStatusHelp);
    console::AddVersion(app, OMNI_VERSION);
    for (const CommandEntry& command : kCommands) command.add(app);
    AddMoved(app, "bench", "omni-bench");
    AddMoved(app, "paper", "omni-bench paper");
    return console::Parse(app, argc, argv).value_or(kExitOk);
  } catch (const std::exception& error) {
    return Fail("omni", error.what());
  }
}

}  // namespace omni::tools
