// The journal of one sculpted object while it is sculpted: its file, locked, and what is still to be written. Edits are
// taken by any thread without touching a disk; Flush writes and syncs them on a thread that may wait.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/base/threads/realtime_threads.h"
#include "service/base/unique_fd.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/journal/journal_format.h"

namespace omni::scene {

// For people. Level 0: a remark, 1: a warning.
struct JournalNote {
  int level = 0;
  std::string text;
};

struct JournalState {
  std::string file;           // empty: there is none yet
  std::uint64_t strokes = 0;  // on the object now
  bool saved = true;
  std::string problem;  // why what was done last is not on the disk; empty: it is, or soon will be
};

struct JournalLimits {
  std::uint64_t folder_bytes = 1ull << 30;   // a new journal is not begun beyond: saved ones are deleted, oldest first
  std::uint64_t growth_bytes = 64ull << 20;  // then old strokes are merged, and cannot be undone after a restart
  std::uint64_t undo_bytes = 16ull << 20;    // that stay when they are
  std::uint64_t waiting_bytes = 256ull << 20;  // for a disk that takes nothing
};

class SculptJournal {
 public:
  // Of an object that has not been edited; `rest`: what turns empty pages into its own.
  SculptJournal(std::string folder, JournalHead head, haptics::sculpt::UndoStep rest, JournalLimits limits = {});
  SculptJournal(const SculptJournal&) = delete;
  SculptJournal& operator=(const SculptJournal&) = delete;

  // First, on a thread that may wait: what an earlier session left. A file that another session still has locked
  // at `until` is left alone; one of another surface, or that cannot be read, is put aside under another name.
  std::optional<JournalContent> Find(std::chrono::steady_clock::time_point until, std::vector<JournalNote>& notes);
  // Then: goes on behind it; or not, since it cannot be used.
  void Resume(const JournalContent& content);
  void PutAside(const std::string& mark, const std::string& why, std::vector<JournalNote>& notes);

  // Any thread; no disk.
  void Append(RecordKind kind, const haptics::sculpt::UndoStep& step);
  std::uint64_t edits() const;          // counts
  void MarkSaved(std::uint64_t edits);  // the state of then was saved
  JournalState state() const;
  std::optional<JournalNote> PopNote();

  // Writer's thread. False: something waits, to be tried again.
  bool Flush();
  // The last call: others may take the file over.
  void Close();

 private:
  struct Edit {
    RecordKind kind;
    haptics::sculpt::UndoStep step;
    std::int64_t time_s;
  };
  std::string PathOf(int slot) const;
  bool Lock(const std::string& path, std::chrono::steady_clock::time_point until, bool& busy);
  void Serialise(const Edit& edit);
  void Put(RecordKind kind, std::int64_t time_s, std::string_view payload);
  std::string Write();  // why not; empty: it is on the disk
  std::string Create(std::string_view content);
  std::string Shorten();
  std::string Who() const { return head_.scene + ": " + head_.object + ": "; }

  const std::string folder_;
  const JournalHead head_;
  const JournalLimits limits_;

  // Of the thread that calls Find, then of the writer's.
  base::UniqueFd fd_;
  std::string path_;
  haptics::sculpt::UndoStep rest_;                        // until there is a file that has it
  std::uint64_t synced_bytes_ = 0, shortened_bytes_ = 0;  // of the file; when it was shortened last
  std::uint32_t number_ = 2;                              // of the next record
  bool closed_ = false;
  std::string unsynced_;                       // whole records
  std::uint64_t undoable_ = 0, redoable_ = 0;  // strokes of the file
  std::uint64_t below_ = 0;                    // undone beyond those

  mutable base::PriorityMutex mutex_;
  std::deque<Edit> waiting_;
  std::uint64_t waiting_bytes_ = 0;
  std::uint64_t edits_ = 0;
  bool given_up_ = false;
  JournalState state_;
  std::deque<JournalNote> notes_;
};

// A scene's sculpted objects get their strokes again, and journals for those to come.

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
