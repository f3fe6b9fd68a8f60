// Results that are expensive to compute, kept on disk by the hash of their inputs. Safe with several processes at once,
// a full disk, a power cut and damaged files: a block is returned only as it was put.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "service/base/big_block.h"
#include "service/scene/cache/sha256.h"

namespace omni::scene {

struct CacheKey {
  std::string kind;  // "scene", "soft": a word of letters, part of the file's name
  Digest digest{};   // of everything the block depends on, the version of the code included
};

// As that of a scene, which takes it over.
using CacheBlock = std::vector<std::byte, base::BigBlockAllocator<std::byte>>;

struct CacheUse {
  std::uint64_t files = 0, bytes = 0;
};

class CacheStore {
 public:
  static constexpr std::uint64_t kDefaultMaxBytes = 2ull << 30;
  static constexpr std::uint64_t kMaxBlockBytes = 1ull << 30;

  // Opens `folder`, created with mode 0700 where it is missing. A folder that is not writable, or that others can
  // write, disables the store: Get finds nothing, Put does nothing, problem() says why.
  explicit CacheStore(std::string folder, std::uint64_t max_bytes = kDefaultMaxBytes);

  const std::string& folder() const { return folder_; }
  const std::string& problem() const { return problem_; }  // empty: in use

  // The block of `key`. A file that is not exactly what Put wrote (length, version, checksum, key) is removed and not
  // returned; `damage` then says what was wrong with it.
  std::optional<CacheBlock> Get(const CacheKey& key, std::string& damage);

  // Written beside, synced, renamed: readers see the old file or the whole new one. Over the size limit the least
  // recently used files are removed. False: not kept (see problem(); or larger than kMaxBlockBytes).
  bool Put(const CacheKey& key, std::span<const std::byte> block);

  void Remove(const CacheKey& key);
  CacheUse Usage() const;
  CacheUse Clear();  // what was removed

 private:
  std::string PathOf(const CacheKey& key) const;
  bool Write(const std::string& path, const CacheKey& key, std::span<const std::byte> block);
  void Evict(const std::string& keep);

  std::string folder_;
  std::uint64_t max_bytes_;
  std::string problem_;
};

// Against damage, not against malice: the folders are ours alone, and readers check what they read before they use it.
// FNV-1a over 64-bit words.
std::uint64_t ChecksumOfBlock(std::span<const std::byte> block);

// Why a folder cannot be one of ours; empty: it can. Created with mode 0700 where it is missing; refused if another
// user owns it or others can write it.
std::string ProblemOfOwnFolder(const std::string& folder);

// Names the code that made a block: a hash over the sources of service/haptics, service/scene and service/base,
// computed by the build (scripts/cmake/build_stamp.cmake). Other code, other stamp, other cache files.
extern const char* const kBuildStamp;

}  // namespace omni::scene
