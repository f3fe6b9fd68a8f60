#include <chrono>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "service/haptics/live/make_live.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/load_scene.h"

namespace omni::scene {
namespace {

CacheKey SoftKeyOf(std::uint64_t input_hash) {
  Sha256 hash;
  hash.Add(std::string_view(kBuildStamp));
  hash.Add(std::as_bytes(std::span(&input_hash, 1)));
  return {"soft", hash.Finish()};
}

// The block is checked in full: SoftBody::Load. Without one, report.cache says why.
std::optional<haptics::SoftBody> FromSoftCache(CacheStore& cache, const CacheKey& key, std::uint64_t input_hash,
                                               SoftLoadReport& report) {
  std::string damage;
  if (const std::optional<CacheBlock> block = cache.Get(key, damage)) {
    base::Result<haptics::SoftBody> body = haptics::SoftBody::Load(*block);
    if (body.ok() && body->view().header().input_hash == input_hash) {
      report.cached = true;
      report.cache = "taken from the cache";
      report.build.bytes = block->size();
      report.build.surface_nodes = body->view().header().node_count;
      return std::move(*body);
    }
    damage = body.ok() ? "is of another mesh" : "holds no soft body (" + body.error() + ")";
    cache.Remove(key);
  }
  report.cache = damage.empty() ? "not in the cache" : "the cached file " + damage + ": rebuilt";
  return std::nullopt;
}

void ToSoftCache(CacheStore& cache, const CacheKey& key, const haptics::SoftBody& body, SoftLoadReport& report) {
  if (cache.Put(key, body.bytes())) {
    report.cache += ", kept";
  } else {
    report.cache = "off: " + (cache.problem().empty() ? "too large to keep" : cache.problem());
  }
}

base::Result<haptics::SoftBody> CachedOrBuilt(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                              CacheStore* cache, SoftLoadReport& report, const SoftBuild& build) {
  if (cache && !cache->problem().empty()) report.cache = "off: " + std::exchange(cache, nullptr)->problem();
  const std::uint64_t input_hash = haptics::SoftBodyKey(mesh.vertices, mesh.triangles, options);
  const CacheKey key = SoftKeyOf(input_hash);
  if (cache) {
    if (std::optional<haptics::SoftBody> cached = FromSoftCache(*cache, key, input_hash, report)) {
      return std::move(*cached);
    }
  }
  base::Result<haptics::SoftBody> body = build(mesh, options, report.build);
  if (body.ok() && cache) ToSoftCache(*cache, key, *body, report);
  return body;
}

}  // namespace

base::Result<haptics::SoftBody> BuildSoftBodyHere(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                                  haptics::SoftBuildReport& report) {
  return haptics::BuildSoftBody(mesh.vertices, mesh.triangles, options, report);
}

base::Result<haptics::SoftBody> LoadSoftBody(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                             CacheStore* cache, SoftLoadReport& report, const SoftBuild& build) {
  const auto start = std::chrono::steady_clock::now();
  report = {};
  base::Result<haptics::SoftBody> body = base::Error{};
  try {
    body = CachedOrBuilt(mesh, options, cache, report, build);
  } catch (const std::bad_alloc&) {
    body = base::Error{"soft body: does not fit into memory; simplify the mesh"};
  } catch (const std::exception& error) {
    body = base::Error{std::string("soft body: ") + error.what()};
  }
  report.load_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return body;
}

LiveReport LoadLive(haptics::Scene& scene, CacheStore* cache, std::uint32_t soft_tets,
                    const std::function<bool(double done)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  LiveReport report;
  haptics::LivePlan plan = haptics::MakeLive(scene);
  report.lines = std::move(plan.lines);
  if (scene.live() != nullptr) report.sculpt_sessions = scene.live()->sculpt_session_count();
  for (const std::uint32_t index : plan.soft) {
    const haptics::Object& object = scene.objects()[index];
    const haptics::Material& material = scene.materials()[haptics::MainMaterial(scene, object)];
    haptics::SoftBodyOptions options = haptics::SoftOptionsOf(material);
    options.lattice.max_tets = soft_tets;
    const double before = static_cast<double>(&index - plan.soft.data()), all = static_cast<double>(plan.soft.size());
    if (progress) options.progress = [&, before, all](double done) { return progress((before + done) / all); };
    SoftLoadReport soft;
    auto body = LoadSoftBody(haptics::MeshOf(scene, index), options, cache, soft);
    if (!body.ok()) {
      report.lines.push_back(std::string(object.name) + ": " + body.error() + ": it stays a layer");
      continue;
    }
    scene.live()->SetSoftBody(index, std::make_unique<const haptics::SoftBody>(std::move(*body)));
    ++report.soft_bodies;
  }
  report.load_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace omni::scene
