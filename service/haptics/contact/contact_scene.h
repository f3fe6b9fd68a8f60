// What the tip may touch in this tick: the scene's meshes as they are now. An object may be moved by the application,
// sculpted, or soft; contacts are computed in its mesh's rest frame, so that queries and proxies need not know.
// docs/theory/haptics.md, section 9.
#pragma once

#include "service/haptics/contact/ball/ball_proxy.h"
#include "service/haptics/contact/frame.h"
#include "service/haptics/geometry/surface.h"
#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/sculpt_query.h"

namespace omni::haptics {

// One object and the tip relative to it. Points in the object's rest frame.
struct Target {
  const Object& object;
  std::uint32_t index;
  std::uint32_t root;  // of its tree
  bool boxed;          // the object's box holds all of it
  Vec3 from, tip;      // the tip at the last tick and now; of a ball, its centre
};

// Of the ball at the pen's tip; 0: a point. Precondition: the scene is not empty.
inline double TipRadius_m(const Scene& scene) noexcept {
  const double radius_m = scene.header().tip_radius_m;
  return radius_m >= kMinBallRadius_m ? std::min(radius_m, kMaxBallRadius_m) : 0;
}

class ContactScene {
 public:
  // Takes the newest sculpted surfaces, soft bodies and poses into `state`. `scene` and `state` outlive this; regions
  // of `state` must not change meanwhile.
  ContactScene(const Scene& scene, const Input& input, State& state) noexcept;

  const Scene& scene() const noexcept { return scene_; }
  double tip_radius_m() const noexcept { return TipRadius_m(scene_); }
  // What touches an object: a ball of this radius, 0: a point; of it, `skin_m` is passed without a force   (12.12).
  struct TipShape {
    double radius_m = 0, skin_m = 0;
  };
  TipShape TipAt(std::uint32_t object) const noexcept {
    const double radius_m = tip_radius_m();
    if (radius_m > 0) return {radius_m, 0};
    const bool open = (scene_.objects()[object].flags & kClosed) == 0 && (has_faces_ >> object & 1) == 0;
    return open ? TipShape{kSkin_m, kSkin_m} : TipShape{};
  }
  const Surface& surface() const noexcept { return surface_; }  // rest meshes and extruded regions

  Target TargetOf(std::uint32_t object) const noexcept;
  Frame FrameOf(std::uint32_t object) const noexcept;
  // How the object moves at a point of it, base frame, m/s.
  Vec3 VelocityOf(std::uint32_t object, const Vec3& point_rest_m) const noexcept;
  // Null: rigid, or a layer.
  const SoftBody* SoftOf(std::uint32_t object) const noexcept {
    return state_.is_soft[object] != 0 ? scene_.live()->soft_body(object) : nullptr;
  }
  // As rendered now; materials that the application has changed are in the state.
  const Material& MaterialAt(std::uint32_t material) const noexcept {
    for (std::uint32_t n = 0; n < live_materials_; ++n) {
      if (state_.materials[n].material == material) return state_.materials[n].now;
    }
    return scene_.materials()[material];
  }
  // The tip over the surface as the soft body carries it under this contact: x - u(s)   (deformable.md 8.1)
  Vec3 TipOver(const Target& target, const ContactState& contact) const noexcept;

  // visit(view) with the mesh of the object: a Surface or a sculpt::SculptSurface.
  template <class Visit>
  decltype(auto) VisitSurface(std::uint32_t object, Visit&& visit) const noexcept {
    const sculpt::SculptTable* table = TableOf(object);
    if (table == nullptr) return visit(surface_);
    const sculpt::SculptSurface sculpted(*table);
    return visit(sculpted);
  }
  // Null: not sculpted.
  const sculpt::SculptTable* TableOf(std::uint32_t object) const noexcept {
    for (std::uint32_t n = 0; n < sculpted_count_; ++n) {
      if (sculpted_[n].object == object) return sculpted_[n].table;
    }
    return nullptr;
  }

  // The object jumped, or its surface was changed: a tip that is inside now did not enter by its own motion.
  bool ChangedUnderTip(std::uint32_t object) const noexcept { return (changed_ >> object & 1) != 0; }
  // A face of the object was pushed or settles.
  bool FaceMoved(std::uint32_t object) const noexcept { return (face_moved_ >> object & 1) != 0; }
  bool anything_moves() const noexcept { return (changed_ | moved_) != 0; }

 private:
  struct Sculpted {
    std::uint32_t object;
    const sculpt::SculptTable* table;
  };
  void TakeSculpted(State& state) noexcept;
  void TakeSoft(State& state) noexcept;
  void TakePoses(const Input& input, State& state) noexcept;
  void FindMovedFaces() noexcept;
  const MovedObject* MovedOf(std::uint32_t object) const noexcept;

  const Scene& scene_;
  const State& state_;
  const Surface surface_;
  const Vec3 tip_base_m_;
  double per_dt_ = 0;  // 1 / dt, 0 for no time
  std::array<Sculpted, kMaxSculpted> sculpted_{};
  std::uint32_t sculpted_count_ = 0;
  std::uint32_t live_materials_ = 0;
  std::uint64_t changed_ = 0, moved_ = 0, face_moved_ = 0;  // one bit per object
  std::uint64_t has_faces_ = 0;                             // that can be extruded
};
static_assert(kMaxObjects <= 64);

// After the tick's contacts are known: objects no longer touched release their soft bodies.
void ForgetUntouched(State& state) noexcept;

}  // namespace omni::haptics
