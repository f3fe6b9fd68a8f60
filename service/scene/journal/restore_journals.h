// A scene's sculpted objects get their strokes again, and journals for those to come.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/scene/journal/sculpt_journal.h"

namespace omni::scene {

struct JournalPlace {
  std::string folder;                        // empty: no journals
  std::string application;                   // each one has its own strokes
  std::string file;                          // of the scene
  std::chrono::milliseconds patience{1000};  // for a session that is just ending
  JournalLimits limits;
};

// One per sculpt session of `scene`, in their order, which gets what its journal holds. Before the scene is in use.
// Reads files and waits for locks.
std::vector<std::shared_ptr<SculptJournal>> RestoreJournals(const haptics::Scene& scene, const JournalPlace& place,
                                                            std::vector<JournalNote>& notes);

}  // namespace omni::scene
