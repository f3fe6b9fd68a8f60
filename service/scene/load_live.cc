#include "service/scene/load_live.h"

#include <chrono>
#include <memory>
#include <utility>

#include "service/haptics/live/make_live.h"

namespace omni::scene {

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
