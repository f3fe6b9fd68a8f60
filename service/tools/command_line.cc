#include "service/tools/command_line.h"

#include <exception>
#include <iostream>
#include <string>

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
constexpr const char* kExitCodes =
    "Exit status: 0 it worked; 1 something did not, stderr says what to do; 2 wrong arguments; 3 omnid does not run.";

void AddVersion(CLI::App& app) {
  app.set_version_flag("--version", std::string("omni ") + OMNI_VERSION, "print the version");
}

int Parse(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& done) {  // how a subcommand hands its status over
    return done.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  return kExitOk;
}

}  // namespace

int Fail(const std::string& command, const std::string& message) {
  std::cerr << command << ": " << message << "\n";
  return kExitFailed;
}

int RunCommandLine(int argc, const char* const* argv) {
  try {
    CLI::App app{kAbout, "omni"};
    app.require_subcommand(1);
    app.footer(kExitCodes);
    AddVersion(app);
    for (const CommandEntry& command : kCommands) command.add(app);
    return Parse(app, argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "omni: " << error.what() << "\n";
    return kExitFailed;
  }
}

}  // namespace omni::tools
