// What omnid (service/daemon/scenes/child_builder.cc) and a process that builds one scene or one soft body say to each
// other over a seqpacket socket. Both are of one build: plain structs. omnid trusts nothing of what it receives.
//
//   scene      omnid: SceneJob + file    builder: Need
//              omnid: Grant + memory     builder: Digest
//              omnid: Build              builder: Finished; the block and the reports (scene::Pack) are in the memory
//   soft body  omnid: SoftJob + mesh and memory   builder: Progress ..., Finished; the block is in the memory
//
// Between SceneJob and Finished the builder may ask for files beside the document: Open, which omnid answers by Opened
// with the file or a reason. To end a builder early, omnid kills it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/scene/gltf/file_bytes.h"

namespace omni::builder {

inline constexpr int kSocket = 3;  // of the builder
inline constexpr std::size_t kMaxMessage = 16384;
inline constexpr std::size_t kMaxText = 8192;                    // of an error or a path
inline constexpr std::size_t kMaxName = scene::kMaxPathBeneath;  // of a file beside the document
inline constexpr std::size_t kMaxTags = 4096;                    // of tags by name
inline constexpr std::uint32_t kMaxOpened = 1000;                // requests for such files

enum class Kind : std::uint32_t {
  kSceneJob = 1,
  kSoftJob,
  kOpened,
  kGrant,
  kBuild,
  kNeed,
  kOpen,
  kDigest,
  kProgress,
  kFinished
};

// A text follows a message that has `text_bytes`.
struct SceneJob {
  Kind kind = Kind::kSceneJob;
  std::uint32_t text_bytes = 0;  // name of the document
  std::uint32_t tags_bytes = 0;  // LoadOptions::tags_by_name, behind the name
  std::uint32_t all_kinematic = 0, touch_untagged = 0, z_up = 0, fit = 0, has_beside = 0;
  double offset_base_m[3]{};
  double scale = 1, hull_radius_m = 0, tip_radius_m = 0;
  std::uint64_t max_file_bytes = 0;
  std::uint32_t max_nodes = 0, max_depth = 0;
};

// The mesh is in memory: its vertices (three doubles), then its triangles (three numbers of 32 bits).
struct SoftJob {
  Kind kind = Kind::kSoftJob;
  std::uint32_t reserved = 0;
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t memory_bytes = 0;  // of the result
  haptics::ElasticModuli moduli;
  haptics::Vec3 fibre;
  haptics::LatticeOptions lattice;
  double clamped_share = 0, hardening = 0, relaxing_share = 0, relaxation_time_s = 0;
};

struct Opened {
  Kind kind = Kind::kOpened;
  std::uint32_t text_bytes = 0;  // why not; 0: the descriptor comes with it
};

struct Grant {
  Kind kind = Kind::kGrant;
  std::uint32_t reserved = 0;
  std::uint64_t memory_bytes = 0;  // of the result
};

struct Build {
  Kind kind = Kind::kBuild;
};

// What the build takes, by the file's JSON. omnid grants it, or refuses; what was granted is enforced.
struct Need {
  Kind kind = Kind::kNeed;
  std::uint32_t reserved = 0;
  std::uint64_t kept_bytes = 0, peak_bytes = 0;
};

struct Open {
  Kind kind = Kind::kOpen;
  std::uint32_t text_bytes = 0;
};

struct Digest {
  Kind kind = Kind::kDigest;
  std::array<std::uint8_t, 32> bytes{};
};

struct Progress {
  Kind kind = Kind::kProgress;
  std::uint32_t reserved = 0;
  double done = 0;
};

enum class Outcome : std::uint32_t { kBuilt = 1, kRefused, kNoMemory, kTooLarge };

struct Finished {
  Kind kind = Kind::kFinished;
  Outcome outcome = Outcome::kRefused;
  std::uint64_t bytes = 0;  // in the memory
  haptics::SoftBuildReport soft;
  std::uint32_t skipped = 0, text_bytes = 0;  // the error
};

static_assert(std::is_trivially_copyable_v<SoftJob> && std::is_trivially_copyable_v<Finished>);

}  // namespace omni::builder
