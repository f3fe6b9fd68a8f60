// Parts of a scene that change while it is in use: soft bodies, which become ready some time after the scene, and
// sculpted surfaces. Made off the tick, owned beside the scene; the tick loads one pointer per part and never waits.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "service/haptics/deformable/soft_body.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/sculpt_session.h"

namespace omni::haptics {

class LiveParts {
 public:
  LiveParts() = default;
  LiveParts(const LiveParts&) = delete;
  LiveParts& operator=(const LiveParts&) = delete;

  // Before the scene is handed to the tick. Precondition: fewer than kMaxSculpted so far, none for this object.
  void AddSculptSession(std::uint32_t object, std::unique_ptr<sculpt::SculptSession> sculpt_session) {
    sculpt_session_of_[object] = sculpt_session.get();
    sculpt_sessions_.push_back(std::move(sculpt_session));
    objects_.push_back(object);
  }
  // One thread besides the tick, at any time, once per object: the tick adopts it as soon as nothing touches the
  // object. Kept for as long as this lives.
  void SetSoftBody(std::uint32_t object, std::unique_ptr<const SoftBody> body) {
    soft_of_[object].store(body.get(), std::memory_order_release);
    bodies_[object] = std::move(body);
  }

  // Any thread. Null: none, or not yet.
  const SoftBody* soft_body(std::uint32_t object) const noexcept {
    return soft_of_[object].load(std::memory_order_acquire);
  }
  sculpt::SculptSession* sculpt_session(std::uint32_t object) const noexcept { return sculpt_session_of_[object]; }

  // The n-th sculpt session and its object, n < sculpt_session_count() <= kMaxSculpted.
  std::uint32_t sculpt_session_count() const noexcept { return static_cast<std::uint32_t>(sculpt_sessions_.size()); }
  sculpt::SculptSession& sculpt_session_at(std::uint32_t n) const noexcept { return *sculpt_sessions_[n]; }
  std::uint32_t object_at(std::uint32_t n) const noexcept { return objects_[n]; }

 private:
  std::array<std::atomic<const SoftBody*>, kMaxObjects> soft_of_{};
  std::array<std::unique_ptr<const SoftBody>, kMaxObjects> bodies_;
  std::array<sculpt::SculptSession*, kMaxObjects> sculpt_session_of_{};
  std::vector<std::unique_ptr<sculpt::SculptSession>> sculpt_sessions_;
  std::vector<std::uint32_t> objects_;
};

}  // namespace omni::haptics
