// The subcommands of omni. Each adds itself to its parent, with a function of its arguments that returns the exit
// status.
#pragma once

#include "service/console/command.h"

namespace omni::tools {

using console::Command;
using console::Option;

void AddStatus(Command& app);
void AddWatch(Command& app);
void AddSurfaces(Command& app);
void AddScene(Command& app);         // omni scene explain, cost, cache, and
void AddSceneEdits(Command& scene);  // omni scene edits, undo, redo, save
void AddDoctor(Command& app);
void AddTwin(Command& app);       // omni twin run, path, and
void AddTwinHand(Command& twin);  // omni twin hand
void AddReport(Command& app);
void AddTrack(Command& app);
void AddCalibrate(Command& app);
void AddAlign(Command& app);
void AddDevice(Command& app);  // omni device list, info, selftest, flash-help, estop
void AddRecord(Command& app);
void AddReplay(Command& app);
void AddLayer(Command& app);  // omni layer enable, disable, status

}  // namespace omni::tools
