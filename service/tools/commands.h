// The subcommands of omni. Each adds itself to the parent and ends its callback with throw CLI::RuntimeError(status).
#pragma once

namespace CLI {
class App;
}

namespace omni::tools {

void AddStatus(CLI::App& app);
void AddWatch(CLI::App& app);
void AddSurfaces(CLI::App& app);
void AddScene(CLI::App& app);  // omni scene explain, cost, cache, edits, undo, redo, save
void AddDoctor(CLI::App& app);
void AddTwin(CLI::App& app);       // omni twin run, path, and
void AddTwinHand(CLI::App& twin);  // omni twin hand
void AddReport(CLI::App& app);
void AddTrack(CLI::App& app);
void AddCalibrate(CLI::App& app);
void AddAlign(CLI::App& app);
void AddDevice(CLI::App& app);  // omni device list, info, selftest, flash-help, estop
void AddRecord(CLI::App& app);
void AddReplay(CLI::App& app);
void AddLayer(CLI::App& app);  // omni layer enable, disable, status

}  // namespace omni::tools
