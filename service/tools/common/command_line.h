// omni: the one command-line tool.
#pragma once

#include <string>

#include "service/console/command.h"

#define OMNI_COMMANDS(COMMAND)                                  \
  COMMAND(Setup)                                                \
  COMMAND(Try)                                                  \
  COMMAND(Status)                                               \
  COMMAND(Watch)                                                \
  COMMAND(Monitor)                                              \
  COMMAND(Stop)                                                 \
  COMMAND(Doctor)                                               \
  COMMAND(Scene) /* explain, cost, cache; edits below */        \
  COMMAND(Twin)  /* run, path; hand below */                    \
  COMMAND(Report)                                               \
  COMMAND(Track)                                                \
  COMMAND(Calibrate)                                            \
  COMMAND(Device) /* list, info, selftest, flash-help, estop */ \
  COMMAND(Record)                                               \
  COMMAND(Replay)                                               \
  COMMAND(Surfaces)                                             \
  COMMAND(Layer) /* enable, disable, status */                  \
  COMMAND(Align)                                                \
  COMMAND(Follow)

namespace omni::tools {

using enum console::ExitStatus;
using console::Fail;
using console::FailUsage;

inline constexpr const char* kOmniAbout = "omni: inspect and set up the Omni haptic base, its service and its scenes";

// Every command but hidden ones.
void AddCommands(console::Program& omni);

// Runs argv; the exit status for main.
int RunCommandLine(int argc, const char* const* argv);

// The subcommands of omni, in the order of its help. Each adds itself to its parent, with a function of its arguments
// that returns the exit status: void AddStatus(Command& app).

using console::Command;
using console::Option;

#define OMNI_DECLARE(name) void Add##name(Command& app);
OMNI_COMMANDS(OMNI_DECLARE)
#undef OMNI_DECLARE

// --socket of a command that is a client of omnid.
void AddSocket(Command& command, std::string& socket);

// --up of a command that loads a scene.
void AddUp(Command& command, std::string& up);

void AddSceneEdits(Command& scene);        // omni scene edits, undo, redo, save
void AddSceneRecover(Command& scene);      // omni scene recover
void AddTwinHand(Command& twin);           // omni twin hand
void AddRehearseController(Command& app);  // what `omni setup --rehearse` aligns with; hidden

}  // namespace omni::tools
