// Distances along the surface from a point on it. docs/theory/sculpting.md, section 2. And the hash map that they and
// regions use.
#pragma once

#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/mesh/paged_mesh.h"

namespace omni::haptics::sculpt {

// Small hash map from vertex or triangle indices to positions in a list; editor's side.
class IndexMap {
 public:
  // kNoIndex: not there.
  std::uint32_t Find(std::uint32_t key) const noexcept {
    if (entries_.empty()) return kNoIndex;
    for (std::size_t at = Home(key);; at = (at + 1) & mask_) {
      if (entries_[at].key == key) return entries_[at].value;
      if (entries_[at].key == kNoIndex) return kNoIndex;
    }
  }
  bool Has(std::uint32_t key) const noexcept { return Find(key) != kNoIndex; }

  // `value` kNoIndex takes the key out. Precondition: key != kNoIndex.
  void Set(std::uint32_t key, std::uint32_t value) {
    if (2 * (used_ + 1) > entries_.size()) Grow();
    std::size_t at = Home(key);
    while (entries_[at].key != key && entries_[at].key != kNoIndex) at = (at + 1) & mask_;
    used_ += entries_[at].key == kNoIndex;
    entries_[at] = {key, value};
  }

 private:
  struct Entry {
    std::uint32_t key = kNoIndex, value = kNoIndex;
  };
  std::size_t Home(std::uint32_t key) const noexcept {
    return static_cast<std::size_t>(key * 0x9e3779b97f4a7c15ULL >> 20) & mask_;
  }
  void Grow() {
    const std::vector<Entry> old = std::move(entries_);
    entries_.assign(old.empty() ? 256 : 2 * old.size(), {});
    mask_ = entries_.size() - 1;
    used_ = 0;
    for (const Entry& e : old) {
      if (e.key != kNoIndex && e.value != kNoIndex) Set(e.key, e.value);
    }
  }

  std::vector<Entry> entries_;
  std::size_t mask_ = 0;
  std::size_t used_ = 0;
};

struct SurfacePoint {
  std::uint32_t triangle = kNoIndex;
  Vec3 position;
};

struct GeodesicVertex {
  std::uint32_t vertex;
  double distance_m;
};

// All vertices nearer than `radius_m` along the surface, nearest first; at most `most`, then the result is longer by
// one. Exact while the surface between is flat and its triangles are not obtuse; elsewhere a little too long.
std::vector<GeodesicVertex> GeodesicBall(const PagedMesh& mesh, const SurfacePoint& from, double radius_m,
                                         std::size_t most);

}  // namespace omni::haptics::sculpt
