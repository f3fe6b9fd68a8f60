#include "service/daemon/scenes/surface_thread.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "service/base/clock.h"

namespace omni::daemon {
namespace {

// Room for a sculpted surface to grow in before it needs another memory.
std::size_t WithHeadroom(std::size_t count) { return count + count / 2 + 4096; }

std::uint32_t SurfaceFlagsOf(const haptics::ChangingObject& object) {
  return (object.soft ? protocol::kSurfaceSoft : 0U) | (object.sculpted ? protocol::kSurfaceSculpted : 0U) |
         (object.extruded ? protocol::kSurfaceExtruded : 0U) | (object.moved ? protocol::kSurfaceMoved : 0U);
}

}  // namespace

SurfacePoller::SurfacePoller(SurfaceSource source)
    : source_(std::move(source)), snapshot_(std::make_unique<loop::SurfaceSnapshot>()) {}

bool SurfacePoller::Poll(std::int64_t now_ns) {
  if (!problem_.empty()) return false;
  TakeSnapshot();
  if (const auto changing = haptics::ChangingObjects(*source_.scene); changing != changing_) Begin(changing);
  if (shown_.empty()) return true;
  bool outgrown = memory_ == nullptr;
  for (Shown& shown : shown_) {
    Refresh(shown);
    outgrown |= shown.vertices.size() > shown.vertex_capacity || shown.triangles.size() > shown.triangle_capacity;
  }
  if (outgrown && !MakeMemory()) return false;
  for (std::size_t i = 0; i < shown_.size(); ++i) Publish(i);
  memory_->PublishPulse(now_ns);
  return true;
}

// Without a tick, or while it still has another scene, everything rests.
void SurfacePoller::TakeSnapshot() {
  const bool there = source_.snapshot(*snapshot_) && snapshot_->scene_generation == source_.scene_generation;
  if (!there) *snapshot_ = {};
}

void SurfacePoller::Begin(const std::vector<haptics::ChangingObject>& changing) {
  changing_ = changing;
  memory_ = nullptr;
  shown_.clear();
  for (const haptics::ChangingObject& object : changing) {
    Shown shown;
    shown.object = object;
    shown.pose.object = object.object;
    if (object.HasVertices() && !object.sculpted) {
      shown.rest = haptics::RestOf(*source_.scene, object.object);
      haptics::DrawnTriangles(*source_.scene, object.object, shown.triangles);
    }
    shown_.push_back(std::move(shown));
  }
}

void SurfacePoller::Refresh(Shown& shown) const {
  // Published before the tick's first snapshot: readers wait for a time, even if nothing changes any more.
  if (!shown.timed && snapshot_->t_ns != 0) shown.new_pose = true;
  if (shown.object.moved) RefreshPose(shown);
  if (shown.object.sculpted) return RefreshSculpted(shown);
  if (shown.object.HasVertices()) RefreshDisplaced(shown);
}

void SurfacePoller::RefreshPose(Shown& shown) const {
  for (const haptics::MovedObject& moved : snapshot_->moved) {
    if (moved.object != shown.object.object) continue;
    if (moved.rotation == shown.pose.rotation && moved.translation_m == shown.pose.translation_m) continue;
    shown.pose = moved;
    shown.new_pose = true;
  }
}

void SurfacePoller::RefreshSculpted(Shown& shown) const {
  haptics::sculpt::SculptSession& sculpt_session = *source_.scene->live()->sculpt_session(shown.object.object);
  const haptics::sculpt::SculptTable* table = sculpt_session.Pin();
  if (table != nullptr && table->generation != shown.sculpt_generation) {
    haptics::CompactSurface(*table, shown.vertices, shown.triangles);
    shown.sculpt_generation = table->generation;
    shown.new_vertices = shown.new_triangles = true;
  }
  sculpt_session.Unpin();
}

void SurfacePoller::RefreshDisplaced(Shown& shown) const {
  std::array<double, haptics::kMaxRegions> offset_m{};
  for (std::size_t r = 0; r < offset_m.size(); ++r) offset_m[r] = snapshot_->regions[r].offset_m;
  const bool touched =
      std::any_of(snapshot_->soft.begin(), snapshot_->soft.end(),
                  [&shown](const haptics::SoftTouch& touch) { return touch.object == shown.object.object; });
  const bool as_before = !touched && !shown.touched && offset_m == shown.offset_m;
  if (as_before && !shown.vertices.empty()) return;
  shown.displacement_m = haptics::DisplacedVertices(
      *source_.scene, {.soft = snapshot_->soft, .regions = snapshot_->regions}, shown.rest, shown.vertices);
  shown.touched = touched;
  shown.offset_m = offset_m;
  shown.new_vertices = true;
}

bool SurfacePoller::MakeMemory() {
  std::vector<protocol::SurfacePlan> plans;
  for (Shown& shown : shown_) {
    const bool grows = shown.object.sculpted;
    shown.vertex_capacity = grows ? WithHeadroom(shown.vertices.size()) : shown.vertices.size();
    shown.triangle_capacity = grows ? WithHeadroom(shown.triangles.size()) : shown.triangles.size();
    shown.new_vertices = shown.new_triangles = shown.new_pose = true;
    plans.push_back({.name = source_.scene->objects()[shown.object.object].name,
                     .object = shown.object.object,
                     .flags = SurfaceFlagsOf(shown.object),
                     .vertex_capacity = static_cast<std::uint32_t>(shown.vertex_capacity),
                     .triangle_capacity = static_cast<std::uint32_t>(shown.triangle_capacity),
                     .triangles_change = grows});
  }
  const ipc::SurfaceMemoryId id{.service_instance = source_.service_instance,
                                .memory_generation = source_.memory_generation->fetch_add(1) + 1,
                                .scene_generation = source_.scene_generation};
  auto made = ipc::SurfacePublisher::Create(id, plans);
  if (!made.ok()) {
    problem_ = made.error();
    memory_ = nullptr;
    return false;
  }
  memory_ = std::move(*made);
  return true;
}

// An update that the publisher refuses (NaN) is tried again; clients keep what they have.
void SurfacePoller::Publish(std::size_t index) {
  Shown& shown = shown_[index];
  if (!shown.new_vertices && !shown.new_triangles && !shown.new_pose) return;
  const base::Quat& q = shown.pose.rotation;
  const base::Vec3& t = shown.pose.translation_m;
  ipc::SurfaceUpdate update{.t_ns = snapshot_->t_ns,
                            .rotation_wxyz = {q.w, q.x, q.y, q.z},
                            .translation_m = {t.x, t.y, t.z},
                            .largest_displacement_m = shown.displacement_m};
  if (shown.new_vertices && shown.object.HasVertices()) update.vertices_base_m = shown.vertices;
  if (shown.new_triangles && shown.object.HasVertices()) update.triangles = shown.triangles;
  if (memory_->Publish(index, update) != ipc::SurfacePublish::kDone) return;
  shown.timed = snapshot_->t_ns != 0;
  shown.new_vertices = shown.new_triangles = shown.new_pose = false;
}

SurfaceThread::SurfaceThread(SurfaceSource source) : poller_(std::move(source)), thread_([this] { Run(); }) {}

SurfaceThread::~SurfaceThread() {
  RequestStop();
  thread_.join();
}

void SurfaceThread::RequestStop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
}

std::shared_ptr<const ipc::SurfacePublisher> SurfaceThread::memory() const {
  const std::lock_guard lock(mutex_);
  return memory_;
}

std::string SurfaceThread::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void SurfaceThread::Run() {
  auto next = std::chrono::steady_clock::now();
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stop_) {
    lock.unlock();
    bool goes_on = false;
    std::string problem;
    try {
      goes_on = poller_.Poll(base::MonotonicNow_ns());
      problem = poller_.problem();
    } catch (const std::exception& caught) {  // out of memory: drawing ends, the service goes on
      problem = std::string("surfaces to draw: ") + caught.what();
    }
    lock.lock();
    memory_ = goes_on ? poller_.memory() : nullptr;
    problem_ = problem;
    if (!goes_on) break;
    // Polls that were missed are not made up for.
    next = std::max(next + std::chrono::nanoseconds(kSurfaceLook_ns), std::chrono::steady_clock::now());
    wake_.wait_until(lock, next, [this] { return stop_; });
  }
  finished_.store(true, std::memory_order_release);
}

}  // namespace omni::daemon
