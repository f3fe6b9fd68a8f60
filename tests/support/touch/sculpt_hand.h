// A pen on a sculpted object in the real tick; the editor runs every few ticks in the same thread, so that runs are
// reproducible.
#pragma once

#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {

class SculptHand {
 public:
  static constexpr double kStiffness_N_m = 400;

  SculptHand(const InputObject& object, const SculptParameters& feel, const Brush& brush,
             const SculptOptions& options = {}, int serve_every = 3)
      : pen_(SceneWith(object, feel, brush, options)),
        sculpt_session_(pen_.scene().live()->sculpt_session_at(0)),
        serve_every_(serve_every) {}

  SculptEditor& editor() { return sculpt_session_.editor(); }

  // One tick; the force on the pen.
  Vec3 MoveTo(const Vec3& tip) {
    const Vec3 before_N = pen_.output.force_base_N;
    pen_.MoveTo(tip);
    if (moved_) largest_step_N_ = std::max(largest_step_N_, Norm(force_N() - before_N));
    moved_ = true;
    if (++ticks_ % serve_every_ == 0) served_ = sculpt_session_.Poll();
    return force_N();
  }
  // At a speed of `speed_m_s`.
  void Go(const Vec3& to, double speed_m_s) {
    const Vec3 from = tip();
    const int ticks = std::max(1, static_cast<int>(std::ceil(Norm(to - from) / (speed_m_s * 1e-3))));
    for (int k = 1; k <= ticks; ++k) MoveTo(from + (static_cast<double>(k) / ticks) * (to - from));
  }
  void Rest(int ticks) {
    for (int k = 0; k < ticks; ++k) MoveTo(tip());
  }
  // A tick without a pose.
  void Lose() {
    pen_.Lose();
    if (++ticks_ % serve_every_ == 0) served_ = sculpt_session_.Poll();
  }

  void Release() { sculpt_session_.Release(); }

  const Vec3& tip() const { return pen_.state.last_device_point_base_m; }
  const SculptToolState& state() const { return pen_.state.sculpted[0].tool; }
  const ServeReport& served() const { return served_; }
  const Vec3& force_N() const { return pen_.output.force_base_N; }
  double largest_step_N() const { return largest_step_N_; }
  void ForgetSteps() { largest_step_N_ = 0; }
  Pen& pen() { return pen_; }

 private:
  static Scene SceneWith(const InputObject& object, const SculptParameters& feel, const Brush& brush,
                         const SculptOptions& options) {
    Material material;
    material.stiffness_N_m = kStiffness_N_m;
    material.static_friction = material.dynamic_friction = 0;
    Scene scene = Built(SceneOf(object, material));
    auto sculpt_session = std::make_unique<SculptSession>(EditorOf(object, options), feel, brush);
    sculpt_session->SetReader(true);
    auto live = std::make_shared<LiveParts>();
    live->AddSculptSession(0, std::move(sculpt_session));
    scene.SetLive(std::move(live));
    return scene;
  }

  Pen pen_;
  SculptSession& sculpt_session_;
  ServeReport served_;
  double largest_step_N_ = 0;
  bool moved_ = false;
  int serve_every_;
  std::uint64_t ticks_ = 0;
};

}  // namespace omni::haptics::sculpt
