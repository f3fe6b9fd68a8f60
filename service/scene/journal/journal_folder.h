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
// So that `bytes` more stay within `limit`: saved journals that are not in use go, the oldest first. Never one that was
// not saved. Why there is no room; empty: there is.
std::string MakeRoomFor(const std::string& folder, std::uint64_t bytes, std::uint64_t limit);

}  // namespace omni::scene
