// Writes sculpt journals on a thread of its own: syncing a file waits for a disk, and neither the sculpt thread nor the
// control thread may. What a disk did not take is tried again.
#pragma once

#include <chrono>
#include <memory>

#include "service/scene/journal/sculpt_journal.h"

namespace omni::daemon {

class JournalWriter {
 public:
  using Journal = std::shared_ptr<scene::SculptJournal>;
  static constexpr std::chrono::milliseconds kPatience{500};  // of the destructor, for a disk that hangs
  static constexpr std::chrono::seconds kTryAgain{5};

  explicit JournalWriter(std::chrono::milliseconds try_again = kTryAgain);
  ~JournalWriter();  // writes what waits, within kPatience
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;

  // Neither waits for a disk. The journal has something to write.
  void Write(const Journal& journal);
  // The same, and then others may take its file over.
  void Close(const Journal& journal);

 private:
  struct Shared;  // shared with the thread, which outlives this when a disk hangs
  const std::shared_ptr<Shared> shared_;
};

}  // namespace omni::daemon
