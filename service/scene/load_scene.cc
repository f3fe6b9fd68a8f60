#include "service/scene/load_scene.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <utility>

#include "service/haptics/live/make_live.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/cache/cached_scene.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/scene_reader.h"
#include "service/scene/tags/haptic_texture.h"

namespace omni::scene {
namespace {

CacheKey KeyOf(const std::string& path, const LoadOptions& options, const Digest& bytes) {
  Sha256 hash;
  hash.Add(std::string_view(kBuildStamp));
  hash.Add(std::as_bytes(std::span(bytes)));
  hash.Add(std::string_view(path));
  for (const double x :
       {options.offset_base_m.x, options.offset_base_m.y, options.offset_base_m.z, options.scale, options.hull_radius_m,
        options.tip_radius_m, options.fit ? 1.0 : 0.0, options.touch_untagged ? 1.0 : 0.0,
        options.all_kinematic ? 1.0 : 0.0, options.z_up ? 1.0 : 0.0}) {
    hash.Add(x);
  }
  hash.Add(std::string_view(options.tags_by_name));
  return {"scene", hash.Finish()};
}

// What each load does about exceptions and time. Lets std::bad_alloc through.
template <class Work>
base::Result<haptics::Scene> Timed(const std::string& path, LoadReport& load, haptics::BuildReport& build, Work work) {
  const auto start = std::chrono::steady_clock::now();
  load = {};
  build = {};
  base::Result<haptics::Scene> scene = base::Error{};
  try {
    scene = work();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const base::Cancelled& cancelled) {
    scene = base::Error{cancelled.what()};
  } catch (const std::exception& error) {
    scene = base::Error{path + ": " + error.what()};
  }
  load.load_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return scene;
}

base::Result<haptics::Scene> Load(const std::string& path, const LoadOptions& options, const LoadSteps& steps,
                                  LoadReport& load, haptics::BuildReport& build) {
  auto reader = std::make_unique<SceneReader>(path, options, load);
  if (steps.admit && !steps.admit(NeedOf(EstimateBuild(reader->Count())))) return base::Error{path + ": is not loaded"};
  if (!reader->ReadBytes()) return haptics::Scene();
  if (!steps.build(reader->FinishDigest())) return base::Error{path + ": is not built"};
  haptics::SceneInput input = reader->MakeInput();
  reader.reset();  // document and decoded meshes: 24 bytes of a triangle
  const base::WorkWatch never;
  const base::WorkWatch& watch = options.watch ? *options.watch : never;
  base::Result<haptics::Scene> scene = haptics::BuildScene(std::move(input), build, watch);
  if (!scene.ok() && scene.error() == base::Cancelled::kWords) return scene;
  if (!scene.ok()) return base::Error{path + ": " + scene.error()};
  watch.Ask();  // nothing of a load that is cancelled is kept
  return scene;
}

constexpr std::uint64_t kMiB = 1 << 20;
constexpr std::uint64_t kProgram = 12 * kMiB;      // of the process that builds
constexpr std::uint64_t kPerJsonByte = 40;         // documents whose values are as short as can be
constexpr std::uint64_t kMostOfJson = 512 * kMiB;  // the limits of json_reading.h
constexpr std::uint64_t kMostBytes = 1ull << 50;   // of sums that are kept in range
constexpr std::uint64_t kSolverPeak = 96 * kMiB;   // of the solver, with the most nodes
constexpr std::uint64_t kSolverPerTriangle = 400;  // of the mesh's tree and skin

}  // namespace

BuildNeed NeedToRead(std::uint64_t json_bytes, std::uint64_t file_bytes) {
  return {0, kProgram + std::min(kMostOfJson, kPerJsonByte * std::min<std::uint64_t>(json_bytes, kSceneJson.bytes)) +
                 std::min<std::uint64_t>(file_bytes, kMaxImageBytes)};
}

BuildNeed NeedOf(const BuildEstimate& estimate) {
  const std::uint64_t peak = std::min(estimate.peak_bytes, kMostBytes);
  return {estimate.kept_bytes, kProgram + std::max(peak, 2 * std::min(estimate.kept_bytes, kMostBytes))};
}

BuildNeed NeedOf(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options) {
  const std::uint64_t kept = haptics::MostSoftBytes(options) + 16 * mesh.vertices.size() + kMiB;
  return {kept, kProgram + kSolverPeak + 2 * kept + kSolverPerTriangle * mesh.triangles.size()};
}

std::uint64_t FileBytesOf(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 ? static_cast<std::uint64_t>(std::max<off_t>(0, status.st_size)) : 0;
}

std::uint64_t JsonBytesOf(int descriptor) {
  std::array<unsigned char, 20> header{};
  const ssize_t got = pread(descriptor, header.data(), header.size(), 0);
  const bool binary = got == static_cast<ssize_t>(header.size()) && std::memcmp(header.data(), "glTF", 4) == 0;
  if (!binary) return FileBytesOf(descriptor);
  return std::uint64_t{header[12]} | std::uint64_t{header[13]} << 8 | std::uint64_t{header[14]} << 16 |
         std::uint64_t{header[15]} << 24;
}

CachedPlace::CachedPlace(CacheStore* cache, const std::string& path, const LoadOptions& options, const Digest& bytes)
    : cache_(cache), key_(cache ? KeyOf(path, options, bytes) : CacheKey{}) {}

std::optional<haptics::Scene> CachedPlace::Take(LoadReport& load, haptics::BuildReport& build) {
  if (cache_ && !cache_->problem().empty()) load.cache = "off: " + std::exchange(cache_, nullptr)->problem();
  if (!cache_) return std::nullopt;
  std::string damage;
  std::optional<CacheBlock> block = cache_->Get(key_, damage);
  if (block) {
    CachedScene cached;
    damage = Unpack(std::move(*block), cached);
    if (damage.empty() && cached.scene.empty()) damage = "has no scene";
    if (damage.empty()) {
      load = std::move(cached.load);
      build = std::move(cached.build);
      return std::move(cached.scene);
    }
    cache_->Remove(key_);
  }
  load.cache = damage.empty() ? "not in the cache" : "the cached file " + damage + ": rebuilt";
  return std::nullopt;
}

void CachedPlace::Keep(std::uint32_t triangles, std::span<const std::byte> packed, LoadReport& load) {
  if (!cache_) return;
  if (triangles < kCachedFromTriangles) {
    load.cache = "not cached: below " + std::to_string(kCachedFromTriangles) + " triangles, quickly built";
  } else if (cache_->Put(key_, packed)) {
    load.cache += load.cache.empty() ? "kept" : ", kept";
  } else {
    load.cache = "off: " + (cache_->problem().empty() ? "too large to keep" : cache_->problem());
  }
}

base::Result<haptics::Scene> LoadInSteps(const std::string& path, const LoadOptions& options, const LoadSteps& steps,
                                         LoadReport& load, haptics::BuildReport& build) {
  return Timed(path, load, build, [&] { return Load(path, options, steps, load, build); });
}

base::Result<haptics::Scene> LoadScene(const std::string& path, const LoadOptions& options, CacheStore* cache,
                                       LoadReport& load, haptics::BuildReport& build) {
  const auto load_cached = [&]() -> base::Result<haptics::Scene> {
    std::optional<CachedPlace> place;
    std::optional<haptics::Scene> cached;
    const LoadSteps steps{.admit = {}, .build = [&](const Digest& bytes) {
                            place.emplace(cache, path, options, bytes);
                            cached = place->Take(load, build);
                            return !cached;
                          }};
    base::Result<haptics::Scene> scene = Load(path, options, steps, load, build);
    if (cached) return std::move(*cached);
    if (scene.ok() && !scene->empty() && cache) {
      place->Keep(scene->header().triangle_count, Pack(*scene, load, build), load);
    }
    return scene;
  };
  try {
    return Timed(path, load, build, load_cached);
  } catch (const std::bad_alloc&) {
    return base::Error{path + ": does not fit into memory; simplify the model"};
  }
}

}  // namespace omni::scene
