// The surface thread: polls the surfaces of one scene 90 times a second for changes by the tick and the editors, and
// publishes them. Exists only while a client draws and the scene has something that changes. It never makes the tick or
// an editor wait: a snapshot comes through base::Latest, a sculpted generation is pinned (SculptPublisher).
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "service/base/threads/realtime_threads.h"
#include "service/haptics/live/surface_frame.h"
#include "service/haptics/scene/scene.h"
#include "service/ipc/surface_publisher.h"
#include "service/loop/surface_snapshot.h"

namespace omni::daemon {

inline constexpr std::int64_t kSurfaceLook_ns = 11'111'111;

struct SurfaceSource {
  std::shared_ptr<const haptics::Scene> scene;  // not null, not empty
  std::uint64_t scene_generation = 0;
  std::uint64_t service_instance = 0;
  // The newest snapshot of the tick; false: there is no tick now. On the surface thread.
  std::function<bool(loop::SurfaceSnapshot&)> snapshot;
  std::atomic<std::uint64_t>* memory_generation = nullptr;  // counts the memories of this service; outlives the thread
};

// The work of the thread, one poll at a time.
class SurfacePoller {
 public:
  explicit SurfacePoller(SurfaceSource source);

  // False: the surfaces cannot be published, problem() says why; further polls do nothing.
  bool Poll(std::int64_t now_ns);
  // The memory being written; replaced by Look when it was outgrown or when more objects change. Null before the first
  // poll, and after a problem.
  const std::shared_ptr<ipc::SurfacePublisher>& memory() const noexcept { return memory_; }
  const std::string& problem() const noexcept { return problem_; }

 private:
  // One object: how it is now, and what of that is not published yet.
  struct Shown {
    haptics::ChangingObject object;
    haptics::RestObject rest;  // unless it is sculpted
    std::vector<haptics::DrawnVertex> vertices;
    std::vector<haptics::DrawnTriangle> triangles;
    haptics::MovedObject pose;
    double displacement_m = 0;
    bool new_vertices = true, new_triangles = true, new_pose = true;
    bool timed = false;                                   // the published frame has the time of a scan
    bool touched = false;                                 // its soft body is deformed
    std::array<double, haptics::kMaxRegions> offset_m{};  // of all regions
    std::uint64_t sculpt_generation = 0;
    std::size_t vertex_capacity = 0, triangle_capacity = 0;  // in the memory
  };
  void TakeSnapshot();
  void Begin(const std::vector<haptics::ChangingObject>& changing);
  void Refresh(Shown& shown) const;
  void RefreshPose(Shown& shown) const;
  void RefreshSculpted(Shown& shown) const;
  void RefreshDisplaced(Shown& shown) const;
  bool MakeMemory();
  void Publish(std::size_t index);

  const SurfaceSource source_;
  std::vector<haptics::ChangingObject> changing_;
  std::vector<Shown> shown_;
  std::shared_ptr<ipc::SurfacePublisher> memory_;
  std::string problem_;
  std::unique_ptr<loop::SurfaceSnapshot> snapshot_;
};

class SurfaceThread {
 public:
  explicit SurfaceThread(SurfaceSource source);
  ~SurfaceThread();  // waits for the poll in progress
  SurfaceThread(const SurfaceThread&) = delete;
  SurfaceThread& operator=(const SurfaceThread&) = delete;

  // Any thread.
  void RequestStop();
  bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }
  std::shared_ptr<const ipc::SurfacePublisher> memory() const;
  std::string problem() const;  // empty: none

 private:
  void Run();

  SurfacePoller poller_;
  mutable base::PriorityMutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  std::shared_ptr<const ipc::SurfacePublisher> memory_;
  std::string problem_;
  std::atomic<bool> finished_{false};
  std::thread thread_;
};

}  // namespace omni::daemon
