#include "service/scene/journal/sculpt_journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <thread>
#include <utility>

#include "service/base/files/whole_file.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/journal/journal_folder.h"

namespace omni::scene {
namespace {

using haptics::sculpt::UndoStep;

constexpr std::chrono::milliseconds kTryAgain{10};
constexpr mode_t kJournalMode = 0600;
constexpr int kMaxSlots = 16;  // sessions of one application with one scene at the same time

std::int64_t UnixNow_s() { return static_cast<std::int64_t>(std::time(nullptr)); }

// Written and synced. 0, or the errno.
int Keep(int fd, std::uint64_t offset, std::string_view bytes) {
  const int error = base::WriteAt(fd, offset, bytes.data(), bytes.size());
  if (error != 0) return error;
  return ::fdatasync(fd) == 0 ? 0 : errno;
}

// A whole journal beside its place, locked before it can be found. 0, or the errno.
int Fill(const base::UnfinishedFile& file, std::string_view content) {
  if (file.error() != 0) return file.error();
  if (::flock(file.fd(), LOCK_EX | LOCK_NB) != 0) return errno;
  return Keep(file.fd(), 0, content);
}

}  // namespace

SculptJournal::SculptJournal(std::string folder, JournalHead head, UndoStep rest, JournalLimits limits)
    : folder_(std::move(folder)), head_(std::move(head)), limits_(limits), rest_(std::move(rest)) {}

std::string SculptJournal::PathOf(int slot) const {
  const std::string number = slot == 1 ? "" : "." + std::to_string(slot);
  return folder_ + "/" + JournalName(head_) + number + std::string(kJournalEnding);
}

// False: there is no such file, or (`busy`) another session has it.
bool SculptJournal::Lock(const std::string& path, std::chrono::steady_clock::time_point until, bool& busy) {
  busy = false;
  while (true) {
    base::UniqueFd fd(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    struct stat info {};
    if (!fd || ::fstat(fd.get(), &info) != 0) return false;
    const bool locked = ::flock(fd.get(), LOCK_EX | LOCK_NB) == 0;
    // The session that had it may have put another file in its place meanwhile.
    if (locked && IsStillAt(fd.get(), path)) {
      fd_ = std::move(fd);
      path_ = path;
      return true;
    }
    if (!locked && std::chrono::steady_clock::now() > until) {
      busy = true;
      return false;
    }
    if (!locked) std::this_thread::sleep_for(kTryAgain);
  }
}

std::optional<JournalContent> SculptJournal::Find(std::chrono::steady_clock::time_point until,
                                                  std::vector<JournalNote>& notes) {
  for (int slot = 1; slot <= kMaxSlots; ++slot) {
    bool busy = false;
    if (!Lock(PathOf(slot), until, busy)) {
      if (!busy) continue;
      notes.push_back({1, Who() + "another session sculpts it too; the strokes of this one are kept apart"});
      continue;
    }
    base::Result<JournalContent> content = ReadJournal(path_);
    if (!content.ok()) {
      PutAside("damaged", content.error(), notes);
    } else if (content->head.identity != head_.identity) {
      PutAside("changed", "the scene's file has changed since " + JournalTimeText(content->time_s), notes);
    } else {
      return std::move(*content);
    }
  }
  return std::nullopt;
}

void SculptJournal::Resume(const JournalContent& content) {
  rest_ = {};
  synced_bytes_ = shortened_bytes_ = content.good_bytes;
  number_ = content.records;
  undoable_ = content.edits.done;
  redoable_ = content.edits.steps.size() - content.edits.done;
  const std::lock_guard lock(mutex_);
  state_ = {.file = path_, .strokes = content.strokes(), .saved = content.saved, .problem = {}};
  if (content.open) waiting_.push_back({RecordKind::kClose, {}, content.time_s});
}

void SculptJournal::PutAside(const std::string& mark, const std::string& why, std::vector<JournalNote>& notes) {
  const std::string stem = path_.substr(0, path_.size() - kJournalEnding.size());
  std::string aside;
  int error = EEXIST;
  for (int n = 1; error == EEXIST; ++n) {
    aside = stem + "." + mark + (n == 1 ? "" : "-" + std::to_string(n)) + std::string(kJournalEnding);
    error = base::MoveToFreeName(path_, aside);
  }
  if (error == 0) base::SyncFolderOf(aside);
  notes.push_back({1, Who() + "strokes are not restored: " + why + "; they are kept in " +
                          (error == 0 ? aside : path_) + " (omni scene recover)"});
  fd_.Reset();
  path_.clear();
}

void SculptJournal::Append(RecordKind kind, const UndoStep& step) {
  const std::lock_guard lock(mutex_);
  ++edits_;
  state_.saved = false;
  if (kind == RecordKind::kStroke || kind == RecordKind::kRedo) ++state_.strokes;
  if (kind == RecordKind::kUndo && state_.strokes > 0) --state_.strokes;
  if (given_up_) return;
  if (!waiting_.empty() && waiting_.back().kind == RecordKind::kOpen) {  // the newer one has it all
    waiting_bytes_ -= waiting_.back().step.bytes();
    waiting_.pop_back();
  }
  waiting_.push_back({kind, step, UnixNow_s()});
  waiting_bytes_ += step.bytes();
  if (waiting_bytes_ <= limits_.waiting_bytes) return;
  given_up_ = true;
  waiting_.clear();
  state_.problem = Who() + "further strokes are not kept: the disk takes none; save them with omni scene save";
  notes_.push_back({1, state_.problem});
}

std::uint64_t SculptJournal::edits() const {
  const std::lock_guard lock(mutex_);
  return edits_;
}

void SculptJournal::MarkSaved(std::uint64_t edits) {
  const std::lock_guard lock(mutex_);
  if (edits != edits_ || state_.saved || given_up_) return;
  state_.saved = true;
  waiting_.push_back({RecordKind::kSaved, {}, UnixNow_s()});
}

JournalState SculptJournal::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

std::optional<JournalNote> SculptJournal::PopNote() {
  const std::lock_guard lock(mutex_);
  if (notes_.empty()) return std::nullopt;
  JournalNote note = std::move(notes_.front());
  notes_.pop_front();
  return note;
}

void SculptJournal::Put(RecordKind kind, std::int64_t time_s, std::string_view payload) {
  unsynced_ += RecordBytes(kind, number_++, time_s, payload);
}

// Undo that goes further back than the file's strokes changes what is under them.
void SculptJournal::Serialise(const Edit& edit) {
  const bool redo_below = edit.kind == RecordKind::kRedo && below_ > 0;
  const bool undo_below = edit.kind == RecordKind::kUndo && undoable_ == 0;
  if (redo_below || undo_below) {
    Put(RecordKind::kBase, edit.time_s, BasePayload(undo_below ? -1 : 1, edit.step));
    below_ += undo_below ? 1 : std::uint64_t{0} - 1;
    return;
  }
  const bool has_step = edit.kind == RecordKind::kStroke || edit.kind == RecordKind::kOpen;
  Put(edit.kind, edit.time_s, has_step ? StepPayload(edit.step) : std::string_view());
  if (edit.kind == RecordKind::kStroke || edit.kind == RecordKind::kClose) {
    ++undoable_;
    redoable_ = below_ = 0;
  } else if (edit.kind == RecordKind::kUndo) {
    --undoable_;
    ++redoable_;
  } else if (edit.kind == RecordKind::kRedo) {
    ++undoable_;
    --redoable_;
  }
}

bool SculptJournal::Flush() {
  if (closed_) return true;
  std::deque<Edit> taken;
  {
    const std::lock_guard lock(mutex_);
    std::swap(taken, waiting_);
  }
  for (const Edit& edit : taken) Serialise(edit);
  std::string problem = unsynced_.empty() ? std::string() : Write();
  const bool kept = problem.empty();
  if (kept && synced_bytes_ > shortened_bytes_ + limits_.growth_bytes) problem = Shorten();
  const std::lock_guard lock(mutex_);
  waiting_bytes_ = unsynced_.size();
  for (const Edit& edit : waiting_) waiting_bytes_ += edit.step.bytes();
  state_.file = path_;
  if (given_up_) return kept;
  if (!problem.empty()) problem = Who() + (kept ? "its journal only grows: " : "strokes are not kept: ") + problem;
  if (problem.empty() != state_.problem.empty()) {
    notes_.push_back(problem.empty() ? JournalNote{0, Who() + "strokes are kept again"} : JournalNote{1, problem});
  }
  state_.problem = std::move(problem);
  return kept;
}

std::string SculptJournal::Write() {
  if (!fd_) {
    std::string content = RecordBytes(RecordKind::kHead, 0, UnixNow_s(), HeadPayload(head_));
    content += RecordBytes(RecordKind::kRest, 1, UnixNow_s(), StepPayload(rest_));
    return Create(content += unsynced_);
  }
  if (!IsStillAt(fd_.get(), path_)) {  // a person has removed it: what it held is still there to be read
    std::string content(synced_bytes_, '\0');
    if (base::ReadAt(fd_.get(), 0, content.data(), content.size()) != 0)
      return path_ + ": was removed, and cannot be read any more";
    return Create(content += unsynced_);
  }
  if (::ftruncate(fd_.get(), static_cast<off_t>(synced_bytes_)) != 0) return base::WriteProblem(path_, errno);
  if (const int error = Keep(fd_.get(), synced_bytes_, unsynced_); error != 0) {
    [[maybe_unused]] const int cut = ::ftruncate(fd_.get(), static_cast<off_t>(synced_bytes_));
    return base::WriteProblem(path_, error);
  }
  synced_bytes_ += unsynced_.size();
  unsynced_.clear();
  return {};
}

// A new file under the first free name; it appears whole and locked.
std::string SculptJournal::Create(std::string_view content) {
  if (std::string problem = ProblemOfOwnFolder(folder_); !problem.empty()) return problem;
  if (std::string problem = MakeRoomFor(folder_, content.size(), limits_.folder_bytes); !problem.empty())
    return problem;
  base::UnfinishedFile file(PathOf(1), kJournalMode);
  if (const int error = Fill(file, content); error != 0) return base::WriteProblem(PathOf(1), error);
  for (int slot = 1; slot <= kMaxSlots; ++slot) {
    const int error = file.Place(PathOf(slot), false);
    if (error == EEXIST) continue;
    if (error != 0) return base::WriteProblem(PathOf(slot), error);
    path_ = PathOf(slot);
    base::SyncFolderOf(path_);
    fd_ = file.Take();
    rest_ = {};
    synced_bytes_ = content.size();
    shortened_bytes_ = std::max(shortened_bytes_, synced_bytes_ - unsynced_.size());
    unsynced_.clear();
    return {};
  }
  return PathOf(1) + ": there are " + std::to_string(kMaxSlots) +
         " of these journals; discard some (omni scene recover --discard)";
}

// Old strokes into the base; a new file in place of the old one.
std::string SculptJournal::Shorten() {
  base::Result<JournalContent> content = ReadJournal(path_);
  if (!content.ok()) return content.error();
  haptics::sculpt::EditHistory& edits = content->edits;
  std::uint64_t bytes = 0;
  for (const UndoStep& step : edits.steps) bytes += step.bytes();
  std::size_t merged = 0;
  haptics::sculpt::StepSum sum;
  sum.Add(edits.base);
  for (; merged < edits.done && bytes > limits_.undo_bytes; ++merged) {
    bytes -= edits.steps[merged].bytes();
    sum.Add(edits.steps[merged]);
  }
  const std::int64_t time_s = content->time_s;
  std::string shorter = RecordBytes(RecordKind::kHead, 0, content->begun_s, HeadPayload(content->head));
  std::uint32_t number = 1;
  const auto put = [&](RecordKind kind, std::string_view payload) {
    shorter += RecordBytes(kind, number++, time_s, payload);
  };
  put(RecordKind::kRest, StepPayload(content->rest));
  put(RecordKind::kBase, BasePayload(content->merged + static_cast<std::int64_t>(merged), sum.Take()));
  for (std::size_t i = merged; i < edits.steps.size(); ++i) put(RecordKind::kStroke, StepPayload(edits.steps[i]));
  for (std::size_t i = edits.done; i < edits.steps.size(); ++i) put(RecordKind::kUndo, {});
  if (content->open) put(RecordKind::kOpen, StepPayload(*content->open));
  if (content->saved) put(RecordKind::kSaved, {});
  base::UnfinishedFile file(path_, kJournalMode);
  int error = Fill(file, shorter);
  if (error == 0) error = file.Place(path_, true);
  shortened_bytes_ = synced_bytes_;  // where it fails: tried again after as many bytes
  if (error != 0) return base::WriteProblem(path_, error);
  base::SyncFolderOf(path_);
  fd_ = file.Take();
  synced_bytes_ = shortened_bytes_ = shorter.size();
  number_ = number;
  undoable_ = edits.done - merged;
  return {};
}

void SculptJournal::Close() {
  fd_.Reset();
  closed_ = true;
}

}  // namespace omni::scene
