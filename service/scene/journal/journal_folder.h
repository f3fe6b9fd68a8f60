// The folder of sculpt journals: names, locks, files that appear whole, and what is removed to make room.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/scene/journal/journal_format.h"

namespace omni::scene {

inline constexpr std::string_view kJournalEnding = ".journal";

std::string JournalName(const JournalHead& head);                // of its file, without folder and ending
std::vector<std::string> JournalsIn(const std::string& folder);  // paths, sorted
base::Result<JournalContent> ReadJournal(const std::string& path);
bool IsJournalInUse(const std::string& path);
base::Status DiscardJournal(const std::string& path);  // refused while it is in use
std::string JournalTimeText(std::int64_t time_s);      // "2026-11-29 12:03", of this place

// For whoever writes them.

bool IsStillAt(int fd, const std::string& path);
// From the beginning, as much as `to` holds.
bool ReadExactly(int fd, std::string& to);
// Written and synced. 0, or the errno.
int WriteAt(int fd, std::uint64_t offset, std::string_view bytes);
// 0, or the errno; EEXIST: the name is taken.
int MoveToFreeName(const std::string& from, const std::string& to);
// So that `bytes` more stay within `limit`: saved journals that are not in use go, the oldest first. Never one that was
// not saved. Why there is no room; empty: there is.
std::string MakeRoomFor(const std::string& folder, std::uint64_t bytes, std::uint64_t limit);

// A file beside `path`, locked from the beginning; gone again unless it was placed.
class UnnamedJournal {
 public:
  explicit UnnamedJournal(const std::string& path);
  ~UnnamedJournal();
  UnnamedJournal(const UnnamedJournal&) = delete;
  UnnamedJournal& operator=(const UnnamedJournal&) = delete;

  // 0, or the errno.
  int Fill(std::string_view content);
  int PlaceNew(const std::string& path);   // EEXIST: there is one
  int PlaceOver(const std::string& path);  // in place of that one
  base::UniqueFd Take() { return std::move(fd_); }

 private:
  std::string name_;
  base::UniqueFd fd_;
  int error_ = 0;
  bool placed_ = false;
};

}  // namespace omni::scene
