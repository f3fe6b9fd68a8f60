// A pen on a sculpted surface, tick by tick: nearest-point contact with a spring, the tool, and the editor served every
// few ticks from the same thread, so that runs are the same everywhere.
#pragma once

#include "service/haptics/geometry/topology.h"
#include "service/haptics/sculpt/handover.h"
#include "service/haptics/sculpt/sculpt_tool.h"
#include "service/haptics/sculpt/stroke_server.h"
#include "tests/support/sculpt_body.h"

namespace omni::haptics::sculpt {

// Angle-weighted pseudonormal, not scaled: only its sign against a direction is used.
inline Vec3 OutwardsAt(const PageView& view, std::uint32_t triangle, const ClosestPoint& at) {
  const Vec3 own = Normalized(AreaVector(view.TriangleCorners(triangle)));
  const Triangle& t = view.GetTriangle(triangle);
  if (at.feature == Feature::kFace) return own;
  if (at.feature == Feature::kEdge) return own + Normalized(AreaVector(view.TriangleCorners(t.neighbour[at.index])));
  Vec3 sum;
  std::uint32_t current = triangle;
  do {
    const Corners c = view.TriangleCorners(current);
    const auto corner = static_cast<std::size_t>(CornerOf(view.GetTriangle(current), t.vertex[at.index]));
    const Vec3 e1 = c[(corner + 1) % 3] - c[corner], e2 = c[(corner + 2) % 3] - c[corner];
    sum = sum + std::atan2(Norm(Cross(e1, e2)), Dot(e1, e2)) * Normalized(AreaVector(c));
    current = view.GetTriangle(current).neighbour[corner];
  } while (current != triangle);
  return sum;
}

class SculptHand {
 public:
  static constexpr double kStiffness_N_m = 400;

  SculptHand(SculptEditor& editor, const SculptFeel& feel, const Brush& brush, int serve_every = 3)
      : feel_(feel), editor_(editor), server_(editor, ring_), serve_every_(serve_every) {
    input_.brush = brush;
    input_.dt_s = 1e-3;
    input_.stiffness_limit_N_m = 1000;
    editor.publisher().SetReader(true);
  }
  ~SculptHand() { editor_.publisher().SetReader(false); }
  SculptHand(const SculptHand&) = delete;
  SculptHand& operator=(const SculptHand&) = delete;

  // One tick; the force wanted, before any limit of the device.
  Vec3 MoveTo(const Vec3& tip) {
    const SculptTable* table = editor_.publisher().Acquire();
    const SculptSurface surface(*table);
    const Vec3 contact_N = fade_.Blend(Touch(surface, tip), input_.dt_s);
    input_.tracked = true;
    input_.velocity_base_m_s = moved_ ? (1 / input_.dt_s) * (tip - input_.tip_base_m) : Vec3{};
    input_.tip_base_m = tip;
    input_.generation = surface.generation();
    const SculptToolOutput out = StepSculptTool(feel_, input_, state_, ring_);
    const Vec3 force_N = out.force_N + out.contact_share * contact_N;
    if (moved_) largest_step_N_ = std::max(largest_step_N_, Norm(force_N - force_N_));
    moved_ = true;
    force_N_ = force_N;
    if (++ticks_ % serve_every_ == 0) served_ = server_.Poll();
    return force_N;
  }
  // At a speed of `speed_m_s`.
  void Go(const Vec3& to, double speed_m_s) {
    const Vec3 from = input_.tip_base_m;
    const int ticks = std::max(1, static_cast<int>(std::ceil(Norm(to - from) / (speed_m_s * input_.dt_s))));
    for (int k = 1; k <= ticks; ++k) MoveTo(from + (static_cast<double>(k) / ticks) * (to - from));
  }
  void Rest(int ticks) {
    for (int k = 0; k < ticks; ++k) MoveTo(input_.tip_base_m);
  }

  const SculptToolState& state() const { return state_; }
  SculptInput& input() { return input_; }
  StrokeRing& ring() { return ring_; }
  StrokeServer& server() { return server_; }
  const ServeReport& served() const { return served_; }
  const Vec3& force_N() const { return force_N_; }
  double largest_step_N() const { return largest_step_N_; }
  void ForgetSteps() { largest_step_N_ = 0; }

 private:
  // Force of the contact, and what the tool is told of it.
  Vec3 Touch(const SculptSurface& surface, const Vec3& tip) {
    const NearestResult nearest = NearestInTree(surface, 0, tip);
    const Vec3 out = nearest.closest.point - tip;
    const bool inside = Dot(out, OutwardsAt(surface, nearest.triangle, nearest.closest)) > 0;
    if (surface.generation() != generation_) {
      const double moved_m = Rebind(surface, 0.01, proxy_);
      if (generation_ != 0 && (input_.touch.touching != inside || (inside && moved_m > kStill_m))) fade_.Start();
      generation_ = surface.generation();
    }
    const double depth_m = Norm(out);
    SculptTouch& touch = input_.touch;
    touch.touching = inside && depth_m > 0;
    touch.triangle = nearest.triangle;
    touch.weights = nearest.closest.weights;
    touch.point_base_m = nearest.closest.point;
    touch.normal = touch.touching ? (1 / depth_m) * out : Vec3{};
    touch.normal_force_N = touch.touching ? kStiffness_N_m * depth_m : 0;
    proxy_ = {nearest.triangle, nearest.closest.weights, nearest.closest.point,
              Normalized(AreaVector(surface.TriangleCorners(nearest.triangle)))};
    return touch.normal_force_N * touch.normal;
  }

  SculptFeel feel_;
  SculptEditor& editor_;
  StrokeRing ring_;
  StrokeServer server_;
  SculptToolState state_;
  SculptInput input_;
  ForceFade fade_;
  KeptFeature proxy_;
  std::uint64_t generation_ = 0;
  ServeReport served_;
  Vec3 force_N_;
  double largest_step_N_ = 0;
  bool moved_ = false;
  int serve_every_;
  std::uint64_t ticks_ = 0;
};

}  // namespace omni::haptics::sculpt
