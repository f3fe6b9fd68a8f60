#include "service/daemon/scenes/client_scenes.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/haptics/scene/scene.h"

namespace omni::daemon {

std::uint32_t TrianglesOf(const haptics::Scene& scene) { return scene.empty() ? 0 : scene.header().triangle_count; }

ClientScenes::ClientScenes(const BuilderOptions& options, Problem problem, Problem say, AppScenes::Send send)
    : hull_radius_m_(options.hull_radius_m),
      tip_radius_m_(options.tip_radius_m),
      problem_(std::move(problem)),
      say_(std::move(say)),
      builder_(options),
      documents_(builder_, options.hull_radius_m, options.tip_radius_m, handed_, std::move(send)) {}

void ClientScenes::Drop(ipc::ClientId id) {
  builder_.Cancel(id);
  const auto found = files_.find(id);
  if (found == files_.end()) return;
  handed_.Retire(std::move(found->second));
  files_.erase(found);
}

void ClientScenes::Remove(ipc::ClientId id) {
  Drop(id);
  documents_.Remove(id);
}

void ClientScenes::HandleResults() {
  while (std::optional<BuiltScene> built = builder_.PopResult()) {
    AppScenes::IsJob(built->client) ? TakeDocument(std::move(*built)) : TakeFileScene(std::move(*built));
  }
  while (const std::optional<BuilderNote> note = builder_.PopNote()) {
    problem_(AppScenes::ClientOf(note->client), 0, note->text);
  }
  while (const std::optional<SoftOutcome> soft = builder_.PopSoftOutcome()) ReportSoftBody(*soft);
  while (const std::optional<SculptProblem> problem = sculpt_.PopProblem()) {
    problem_(problem->client, 1, problem->text);
  }
  while (const std::optional<SculptProblem> note = sculpt_.PopJournalNote())
    say_(note->client, note->level, note->text);
}

void ClientScenes::TakeFileScene(BuiltScene built) {
  const ipc::ClientId id = built.client;
  for (const std::string& warning : built.warnings) spdlog::warn("{}", warning);
  if (built.scene == nullptr) return problem_(id, 2, built.error);  // the client's previous scene, if any, stays
  if (built.load.skipped) {
    problem_(id, 0,
             built.file +
                 ": nothing to touch: the file has no haptic tag; tag the objects to touch (docs/scenes.md), or "
                 "write touch = \"all\" in the application's file");
  } else {
    spdlog::info("client {}: scene {} ({} triangles, {} in {:.1f} ms)", id, built.file, TrianglesOf(*built.scene),
                 built.load.cached ? "from the cache" : "built", built.load.load_ms);
  }
  for (const scene::JournalNote& note : built.notes) problem_(id, note.level, note.text);
  sculpt_.Add(id, built.file, built.scene, built.journals);
  handed_.Retire(std::exchange(files_[id], std::make_shared<const BuiltScene>(std::move(built))));
}

// Errors are reported to its client by its state, and logged here.
void ClientScenes::TakeDocument(BuiltScene built) {
  const ipc::ClientId id = AppScenes::ClientOf(built.client);
  const std::string error = built.error;
  const std::shared_ptr<const BuiltScene> scene = documents_.Accept(std::move(built));
  if (scene == nullptr) {
    if (!error.empty()) problem_(0, 1, error);
    return;
  }
  spdlog::info("client {}: {} ({} triangles in {:.1f} ms)", id, scene->file, TrianglesOf(*scene->scene),
               scene->load.load_ms);
  sculpt_.Add(id, scene->file, scene->scene);
}

void ClientScenes::ReportSoftBody(const SoftOutcome& soft) {
  const ipc::ClientId id = AppScenes::ClientOf(soft.client);
  const std::string what = soft.file + ": " + soft.object + ": ";
  if (!soft.error.empty()) return problem_(id, 1, what + soft.error + ": it stays a layer");
  spdlog::info("client {}: {}soft body with {} nodes, {:.1f} MB, {} in {:.0f} ms", id, what,
               soft.report.build.surface_nodes, static_cast<double>(soft.report.build.bytes) * 1e-6,
               soft.report.cached ? "from the cache" : "computed", soft.report.load_ms);
}

std::shared_ptr<const BuiltScene> ClientScenes::Of(ipc::ClientId id) const {
  if (documents_.HasBeenReady(id)) return documents_.ActiveScene(id);
  const auto found = files_.find(id);
  return found == files_.end() ? nullptr : found->second;
}

SoftProgress ClientScenes::ProgressOf(ipc::ClientId id) const {
  const std::shared_ptr<const BuiltScene> scene = Of(id);
  return builder_.Progress(scene == nullptr ? id : scene->client);
}

void ClientScenes::SetOwner(ipc::ClientId owner) {
  if (handed_.Give(Of(owner)) && felt() != nullptr) sculpt_.EnterScene(*felt()->scene);
}

loop::SceneControl ClientScenes::ControlOf(ipc::ClientId owner) const {
  loop::SceneControl control;
  if (documents_.ActiveScene(owner) != nullptr) documents_.FillControl(owner, generation(), control);
  return control;
}

void ClientScenes::Release(std::optional<std::uint64_t> taken) {
  for (const std::shared_ptr<const BuiltScene>& scene : handed_.Release(taken)) {
    if (scene == handed_.newest()) continue;  // it came back
    sculpt_.LeaveScene(*scene->scene);
    const bool kept = documents_.Contains(scene) || std::any_of(files_.begin(), files_.end(), [&](const auto& entry) {
                        return entry.second == scene;
                      });
    if (!kept) sculpt_.Remove(*scene->scene);
  }
}

}  // namespace omni::daemon
