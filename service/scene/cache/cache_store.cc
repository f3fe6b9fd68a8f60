#include "service/scene/cache/cache_store.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>

#include "service/base/files/whole_file.h"

namespace omni::scene {
namespace {

constexpr std::uint32_t kCacheMagic = 0x43494D4F;  // "OMIC"
constexpr std::uint32_t kCacheFormat = 1;
constexpr const char* kSuffix = ".omnicache";
constexpr std::time_t kUnfinishedAge_s = 3600;  // what a killed process left behind

struct FileHeader {
  std::uint32_t magic;
  std::uint32_t format;
  std::uint64_t bytes;     // of the block that follows
  std::uint64_t checksum;  // of the block
  std::array<char, 8> kind;
  Digest key;
};
static_assert(sizeof(FileHeader) == 64);

FileHeader HeaderOf(const CacheKey& key, std::span<const std::byte> block) {
  FileHeader header{kCacheMagic, kCacheFormat, block.size(), ChecksumOfBlock(block), {}, key.digest};
  key.kind.copy(header.kind.data(), header.kind.size());
  return header;
}

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  int get() const { return descriptor_; }
  bool open() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

std::string CacheReason(int error) { return std::error_code(error, std::generic_category()).message(); }

struct Entry {
  std::string name;
  std::uint64_t bytes;
  timespec used;  // last read or written: Get touches the file
};

bool IsUnfinished(const std::string& name) {
  return name.find(kSuffix + std::string(base::kUnfinishedMark)) != std::string::npos;
}

std::vector<Entry> EntriesOf(const std::string& folder) {
  std::vector<Entry> entries;
  const std::unique_ptr<DIR, int (*)(DIR*)> directory(opendir(folder.c_str()), closedir);
  if (!directory) return entries;
  while (const dirent* item = readdir(directory.get())) {
    const std::string name = item->d_name;
    struct stat status {};
    if (!(name.ends_with(kSuffix) || IsUnfinished(name))) continue;
    if (lstat((folder + "/" + name).c_str(), &status) != 0 || !S_ISREG(status.st_mode)) continue;
    entries.push_back({name, static_cast<std::uint64_t>(status.st_size), status.st_mtim});
  }
  return entries;
}

bool Older(const Entry& a, const Entry& b) {
  if (a.used.tv_sec != b.used.tv_sec) return a.used.tv_sec < b.used.tv_sec;
  return a.used.tv_nsec != b.used.tv_nsec ? a.used.tv_nsec < b.used.tv_nsec : a.name < b.name;
}

}  // namespace

std::uint64_t ChecksumOfBlock(std::span<const std::byte> block) {
  std::uint64_t sum = 0xcbf29ce484222325ULL;
  std::size_t i = 0;
  for (; i + 8 <= block.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, &block[i], 8);
    sum = (sum ^ word) * 0x100000001b3ULL ^ (sum >> 29);
  }
  for (; i < block.size(); ++i) sum = (sum ^ static_cast<std::uint64_t>(block[i])) * 0x100000001b3ULL;
  return sum;
}

std::string ProblemOfOwnFolder(const std::string& folder) {
  if (folder.empty()) return "no home folder";
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(folder).parent_path(), error);
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
    return folder + ": cannot be created (" + CacheReason(errno) + ")";
  struct stat status {};
  if (lstat(folder.c_str(), &status) != 0) return folder + ": cannot be examined (" + CacheReason(errno) + ")";
  if (!S_ISDIR(status.st_mode)) return folder + ": is not a folder";
  if (status.st_uid != geteuid()) return folder + ": belongs to another user";
  if ((status.st_mode & 0022) != 0) return folder + ": can be written by others; chmod 700 it";
  if (access(folder.c_str(), W_OK | X_OK) != 0) return folder + ": cannot be written (" + CacheReason(errno) + ")";
  return {};
}

CacheStore::CacheStore(std::string folder, std::uint64_t max_bytes)
    : folder_(std::move(folder)), max_bytes_(max_bytes), problem_(ProblemOfOwnFolder(folder_)) {}

std::string CacheStore::PathOf(const CacheKey& key) const {
  return folder_ + "/" + key.kind + "-" + ToHex(key.digest) + kSuffix;
}

std::optional<CacheBlock> CacheStore::Get(const CacheKey& key, std::string& damage) {
  damage.clear();
  if (!problem_.empty()) return std::nullopt;
  const File file(open(PathOf(key).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!file.open()) return std::nullopt;
  struct stat status {};
  FileHeader header{};
  CacheBlock block;
  if (fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != geteuid()) {
    damage = "is not a regular file owned by this user";
  } else if (base::ReadAt(file.get(), 0, &header, sizeof header) != 0) {
    damage = "ends inside its header";
  } else if (header.magic != kCacheMagic || header.format != kCacheFormat) {
    damage = "has an unknown format";
  } else if (header.key != key.digest) {
    damage = "belongs to another key";
  } else if (!(header.bytes <= kMaxBlockBytes &&
               header.bytes + sizeof header == static_cast<std::uint64_t>(status.st_size))) {
    damage = "has " + std::to_string(status.st_size) + " bytes, its header says otherwise";
  } else {
    block.resize(static_cast<std::size_t>(header.bytes));
    if (base::ReadAt(file.get(), sizeof header, block.data(), block.size()) != 0) damage = "cannot be read";
    if (damage.empty() && ChecksumOfBlock(block) != header.checksum) damage = "has a wrong checksum";
  }
  if (!damage.empty()) {
    Remove(key);
    return std::nullopt;
  }
  futimens(file.get(), nullptr);  // least recently used is removed first; where it fails, age decides
  return block;
}

bool CacheStore::Put(const CacheKey& key, std::span<const std::byte> block) {
  if (!problem_.empty() || block.size() > kMaxBlockBytes || block.size() > max_bytes_) return false;
  const std::string path = PathOf(key);
  if (!Write(path, key, block)) return false;
  Evict(path);
  return true;
}

bool CacheStore::Write(const std::string& path, const CacheKey& key, std::span<const std::byte> block) {
  const FileHeader header = HeaderOf(key, block);
  const std::string_view head(reinterpret_cast<const char*>(&header), sizeof header);
  const std::string_view body(reinterpret_cast<const char*>(block.data()), block.size());
  const int error = base::PutWholeFile(path, {head, body}, {.mode = 0600});
  if (error != 0) problem_ = base::WriteProblem(path, error) + "; scenes are built each time until then";
  return error == 0;
}

void CacheStore::Evict(const std::string& keep) {
  std::vector<Entry> entries = EntriesOf(folder_);
  std::sort(entries.begin(), entries.end(), Older);
  std::uint64_t sum = 0;
  for (const Entry& entry : entries) sum += entry.bytes;
  const std::time_t now = std::time(nullptr);
  for (const Entry& entry : entries) {
    const std::string path = folder_ + "/" + entry.name;
    const bool unfinished = IsUnfinished(entry.name);
    const bool goes = unfinished ? now - entry.used.tv_sec > kUnfinishedAge_s : sum > max_bytes_ && path != keep;
    if (goes && unlink(path.c_str()) == 0) sum -= entry.bytes;
  }
}

void CacheStore::Remove(const CacheKey& key) { unlink(PathOf(key).c_str()); }

CacheUse CacheStore::Usage() const {
  CacheUse use;
  for (const Entry& entry : EntriesOf(folder_)) {
    ++use.files;
    use.bytes += entry.bytes;
  }
  return use;
}

CacheUse CacheStore::Clear() {
  CacheUse removed;
  if (!problem_.empty()) return removed;
  for (const Entry& entry : EntriesOf(folder_)) {
    if (unlink((folder_ + "/" + entry.name).c_str()) != 0) continue;
    ++removed.files;
    removed.bytes += entry.bytes;
  }
  return removed;
}

}  // namespace omni::scene
