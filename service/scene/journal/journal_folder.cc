#include "service/scene/journal/journal_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <system_error>

#include "service/base/files/whole_file.h"
#include "service/scene/cache/sha256.h"

namespace omni::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNameLength = 40;      // of each part
constexpr std::time_t kLeftBehind_s = 3600;  // what a killed process left behind

// Letters, digits and a few signs; the others become underscores.
std::string Plain(const std::string& text) {
  std::string plain = text.substr(0, kNameLength);
  for (char& c : plain) {
    const bool kept = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-';
    if (!kept) c = '_';
  }
  return plain.empty() ? "_" : plain;
}

struct FolderEntry {
  std::string path;
  std::uint64_t bytes = 0;
  std::time_t changed_s = 0;
  bool unfinished = false;
};

// Regular files that are journals, or were to become some.
std::vector<FolderEntry> EntriesIn(const std::string& folder) {
  std::vector<FolderEntry> entries;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string path = at->path().string();
    const bool unfinished = path.find(std::string(kJournalEnding) + std::string(base::kUnfinishedMark)) != path.npos;
    struct stat info {};
    if (!unfinished && !path.ends_with(kJournalEnding)) continue;
    if (::lstat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) continue;
    entries.push_back({path, static_cast<std::uint64_t>(info.st_size), info.st_mtime, unfinished});
  }
  return entries;
}

// Opened and locked; none: in use, or not there.
base::UniqueFd LockedFile(const std::string& path) {
  base::UniqueFd fd(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!fd || ::flock(fd.get(), LOCK_EX | LOCK_NB) != 0 || !IsStillAt(fd.get(), path)) return {};
  return fd;
}

bool IsSaved(int fd, std::uint64_t bytes) {
  char last[kRecordHeaderBytes];
  return bytes >= sizeof last &&
         ::pread(fd, last, sizeof last, static_cast<off_t>(bytes - sizeof last)) == static_cast<ssize_t>(sizeof last) &&
         EndsSaved({last, sizeof last});
}

std::string MegaBytes(std::uint64_t bytes) { return std::to_string((bytes + 500'000) / 1'000'000) + " MB"; }

}  // namespace

std::string JournalName(const JournalHead& head) {
  Sha256 hash;
  for (const std::string* text : {&head.application, &head.scene, &head.object}) hash.Add(std::string_view(*text));
  return Plain(fs::path(head.scene).stem().string()) + "-" + Plain(head.object) + "-" +
         ToHex(hash.Finish()).substr(0, 12);
}

std::vector<std::string> JournalsIn(const std::string& folder) {
  std::vector<std::string> paths;
  for (const FolderEntry& entry : EntriesIn(folder)) {
    if (!entry.unfinished) paths.push_back(entry.path);
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

base::Result<JournalContent> ReadJournal(const std::string& path) {
  const base::Result<std::string> bytes = base::ReadFile(path, kMaxJournalBytes);
  if (!bytes.ok()) return base::Error{bytes.error()};
  base::Result<JournalContent> content = ParseJournal(*bytes);
  if (!content.ok()) return base::Error{path + ": no sculpt journal can be read from it: it " + content.error()};
  return content;
}

bool IsJournalInUse(const std::string& path) {
  const base::UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  return fd && ::flock(fd.get(), LOCK_SH | LOCK_NB) != 0;
}

base::Status DiscardJournal(const std::string& path) {
  if (IsJournalInUse(path)) {
    return base::Error{path +
                       ": is in use; end the application's session first, or undo the strokes (omni scene undo)"};
  }
  const base::UniqueFd lock = LockedFile(path);
  return base::RemoveWholeFile(path);
}

std::string JournalTimeText(std::int64_t time_s) {
  const auto time = static_cast<std::time_t>(time_s);
  std::tm local{};
  char text[64];
  if (::localtime_r(&time, &local) == nullptr) return "?";
  return std::string(text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local));
}

bool IsStillAt(int fd, const std::string& path) {
  struct stat mine {
  }, there{};
  return ::fstat(fd, &mine) == 0 && ::lstat(path.c_str(), &there) == 0 && mine.st_ino == there.st_ino &&
         mine.st_dev == there.st_dev;
}

std::string MakeRoomFor(const std::string& folder, std::uint64_t bytes, std::uint64_t limit) {
  std::vector<FolderEntry> entries = EntriesIn(folder);
  std::sort(entries.begin(), entries.end(), [](const FolderEntry& a, const FolderEntry& b) {
    return a.changed_s != b.changed_s ? a.changed_s < b.changed_s : a.path < b.path;
  });
  const std::time_t now_s = std::time(nullptr);
  std::uint64_t sum = bytes;
  for (const FolderEntry& entry : entries) {
    const bool left_behind = entry.unfinished && now_s - entry.changed_s > kLeftBehind_s;
    if (!left_behind || ::unlink(entry.path.c_str()) != 0) sum += entry.bytes;
  }
  for (const FolderEntry& entry : entries) {
    if (sum <= limit) return {};
    const base::UniqueFd fd = entry.unfinished ? base::UniqueFd() : LockedFile(entry.path);
    if (fd && IsSaved(fd.get(), entry.bytes) && ::unlink(entry.path.c_str()) == 0) sum -= entry.bytes;
  }
  if (sum <= limit) return {};
  return folder + ": holds " + MegaBytes(sum - bytes) + " of strokes that were not saved, the limit is " +
         MegaBytes(limit) + "; save or discard some (omni scene recover)";
}

}  // namespace omni::scene
