#include "service/tools/command_line.h"

#include <exception>

#include <CLI/CLI.hpp>

#include "service/tools/commands.h"

namespace omni::tools {
namespace {

// One row a subcommand.
struct CommandEntry {
  void (*add)(CLI::App& app);
};
constexpr CommandEntry kCommands[] = {{AddStatus}, {AddWatch},    {AddDoctor}, {AddScene},     {AddTwin},   {AddBench},
                                      {AddReport}, {AddTrack},    {AddPaper},  {AddCalibrate}, {AddDevice}, {AddRecord},
                                      {AddReplay}, {AddSurfaces}, {AddLayer},  {AddAlign}};

constexpr const char* kAbout = "omni: see and check the Omni haptic base, its service and its scenes";

}  // namespace

int RunCommandLine(int argc, const char* const* argv) {
  try {
    CLI::App app{kAbout, "omni"};
    app.require_subcommand(1);
    app.footer(console::kExitStatusHelp);
    console::AddVersion(app, OMNI_VERSION);
    for (const CommandEntry& command : kCommands) command.add(app);
    return console::Parse(app, argc, argv).value_or(kExitOk);
  } catch (const std::exception& error) {
    return Fail("omni", error.what());
  }
}

}  // namespace omni::tools
