// Strokes of a tip over a body at 1 kHz, in six styles. Each begins and ends in free space.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/support/touch/ball_judge.h"

namespace omni::haptics {

enum class StrokeStyle : std::uint8_t { kPress, kSlide, kPoke, kCircle, kEdge, kCorner };
struct NamedStyle {
  StrokeStyle style;
  const char* name;
};
inline constexpr std::array<NamedStyle, 6> kStrokeStyles{{
    {StrokeStyle::kPress, "press"},    // 20 mm/s in, held by a hand that trembles, and out
    {StrokeStyle::kSlide, "slide"},    // up to 150 mm/s over faces, edges and grooves, pressed by up to 2 mm
    {StrokeStyle::kPoke, "poke"},      // in at 1 m/s, and out
    {StrokeStyle::kCircle, "circle"},  // of 0.5 to 4 mm at 100 mm/s
    {StrokeStyle::kEdge, "edge"},      // along one edge of the mesh, from one side of it to the other
    {StrokeStyle::kCorner, "corner"},  // straight through the body beneath a corner, with tremor
}};

class TipStrokes {
 public:
  // `radius_m` of the ball, 0: a point; the places are those of its centre.
  TipStrokes(const InputObject& object, const Scene& scene, double radius_m, StrokeStyle style, std::uint64_t seed)
      : surface_(scene, {}),
        built_(scene.objects()[0]),
        corners_(CornersOf(object)),
        oracle_(corners_),
        radius_m_(radius_m),
        style_(style),
        random_(seed) {}

  // Empty: no place for such a stroke was found.
  std::vector<Vec3> Next() {
    for (int attempt = 0; attempt < 200; ++attempt) {
      std::vector<Vec3> path = Draw();
      if (!path.empty() && IsFree(path.front()) && IsFree(path.back()) && IsWhole(path)) return path;
    }
    return {};
  }

 private:
  static constexpr double kAbove_m = 1.5e-3;
  static constexpr double kOfThickness = 0.3;  // deepest: beyond the middle another side is nearer
  struct Foot {
    Vec3 point, normal;
  };

  bool IsFree(const Vec3& p) { return !oracle_.IsInside(p) && oracle_.Distance(p) > radius_m_ + 1e-4; }

  // No step is longer than a tick's at 1.2 m/s.
  static bool IsWhole(const std::vector<Vec3>& path) {
    for (std::size_t k = 1; k < path.size(); ++k) {
      if (!(Norm(path[k] - path[k - 1]) < 1.2e-3)) return false;
    }
    return true;
  }

  // Length of the straight line through the body from a place of its surface   [Moeller & Trumbore 1997].
  double Thickness(const Vec3& from, const Vec3& inwards) const {
    double least_m = 0.1;
    for (const Corners& c : corners_) {
      const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0], p = Cross(inwards, e2), s = from - c[0];
      const double det = Dot(e1, p);
      if (std::abs(det) < 1e-18) continue;
      const double u = Dot(s, p) / det, v = Dot(inwards, Cross(s, e1)) / det, t = Dot(e2, Cross(s, e1)) / det;
      if (u >= -1e-9 && v >= -1e-9 && u + v <= 1 + 1e-9 && t > 1e-5) least_m = std::min(least_m, t);
    }
    return least_m;
  }
  double Deepest(const Foot& foot, double press_m) const {
    return std::min(press_m, kOfThickness * Thickness(foot.point, -foot.normal));
  }
  Vec3 Over(const Foot& foot, double height_m) const { return foot.point + (radius_m_ + height_m) * foot.normal; }

  std::uint32_t AnyTriangle() { return static_cast<std::uint32_t>(random_.Next() % corners_.size()); }
  static Vec3 NormalOf(const Corners& c) { return Normalized(Cross(c[1] - c[0], c[2] - c[0])); }
  Foot AnyFoot() {
    const Corners& c = corners_[AnyTriangle()];
    const double a = random_.Uniform(0, 1), b = random_.Uniform(0, 1);
    const double u = a + b > 1 ? 1 - a : a, v = a + b > 1 ? 1 - b : b;
    return {c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]), NormalOf(c)};
  }
  Foot FootAt(const Vec3& near_m) const {
    const NearestResult at = support::NearestPoint(surface_, built_, near_m);
    return {at.closest.point, FaceNormal(surface_, at.triangle)};
  }
  static Vec3 Across(const Vec3& n) {
    return Normalized(Cross(n, std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  }

  // Straight, one place per tick; the path goes on from its end.
  static void Go(const Vec3& to, double speed_m_s, std::vector<Vec3>& path) {
    const Vec3 from = path.back();
    const int ticks = std::max(1, static_cast<int>(std::ceil(Norm(to - from) / (1e-3 * speed_m_s))));
    for (int k = 1; k <= ticks; ++k) path.push_back(from + (static_cast<double>(k) / ticks) * (to - from));
  }

  std::vector<Vec3> Draw() {
    switch (style_) {
      case StrokeStyle::kPress:
        return Press(0.02, 150);
      case StrokeStyle::kPoke:
        return Press(1, 2);
      case StrokeStyle::kSlide:
        return Slide();
      case StrokeStyle::kCircle:
        return Circle();
      case StrokeStyle::kEdge:
        return AlongEdge();
      case StrokeStyle::kCorner:
        return ThroughCorner();
    }
    return {};
  }

  // A hand's tremor after k ticks: 9 Hz, 0.1 mm.
  static double Tremor(int k) { return 1e-4 * std::sin(2 * std::numbers::pi * 9e-3 * k); }

  std::vector<Vec3> Press(double speed_m_s, int hold_ticks) {
    const Foot foot = AnyFoot();
    const double deep_m = Deepest(foot, random_.Uniform(2e-4, 2e-3));
    std::vector<Vec3> path{Over(foot, kAbove_m)};
    Go(Over(foot, -deep_m), speed_m_s, path);
    const Vec3 side = Across(foot.normal);
    const Vec3 held = path.back();
    for (int k = 1; k <= hold_ticks; ++k) path.push_back(held + Tremor(k) * side + Tremor(k + 40) * foot.normal);
    Go(Over(foot, kAbove_m), speed_m_s, path);
    return path;
  }

  // The foot goes on over the surface, around edges and through grooves; the tip follows at its speed.
  std::vector<Vec3> Slide() {
    Foot foot = AnyFoot();
    const double step_m = 1e-5 * std::exp(random_.Uniform(0.7, 2.7)), press_m = random_.Uniform(2e-4, 2e-3);
    std::vector<Vec3> path{Over(foot, kAbove_m)};
    Vec3 heading = random_.InBox(1);
    for (int k = 0; k < 400; ++k) {
      heading = Normalized(heading + random_.InBox(0.05));
      const Vec3 along = Normalized(heading - Dot(heading, foot.normal) * foot.normal);
      if (k > 40) foot = FootAt(foot.point + step_m * (along - 0.5 * foot.normal));
      Follow(foot, Deepest(foot, press_m * (0.6 + 0.4 * std::sin(0.02 * k))), 3 * step_m + 4e-5, path);
    }
    Go(Over(foot, kAbove_m), 0.1, path);
    return path;
  }
  void Follow(const Foot& foot, double deep_m, double most_m, std::vector<Vec3>& path) const {
    const Vec3 way = Over(foot, -deep_m) - path.back();
    path.push_back(path.back() + std::min(1.0, most_m / std::max(Norm(way), 1e-12)) * way);
  }

  std::vector<Vec3> Circle() {
    const Foot middle = AnyFoot();
    const double circle_m = random_.Uniform(5e-4, 4e-3), press_m = random_.Uniform(2e-4, 1.5e-3);
    const Vec3 e1 = Across(middle.normal), e2 = Cross(middle.normal, e1);
    Foot foot = middle;
    std::vector<Vec3> path{Over(middle, kAbove_m)};
    for (int k = 0; k < 350; ++k) {
      const double angle = 1e-4 * k / circle_m, grown_m = circle_m * std::min(1.0, k / 40.0);
      foot = FootAt(middle.point + grown_m * (std::cos(angle) * e1 + std::sin(angle) * e2));
      Follow(foot, Deepest(foot, press_m), 3e-4, path);
    }
    Go(Over(foot, kAbove_m), 0.1, path);
    return path;
  }

  std::vector<Vec3> AlongEdge() {
    const std::size_t t = AnyTriangle(), k = random_.Next() % 3;
    const Corners& c = corners_[t];
    const Vec3 from = c[k], to = c[(k + 1) % 3], middle = 0.5 * (from + to);
    Vec3 normal = NormalOf(c);
    for (const Corners& other : corners_) {
      if (&other != &c && Norm(support::NearestOnTriangle(other, middle) - middle) < 1e-9)
        normal = normal + NormalOf(other);
    }
    const Foot first{middle, Normalized(normal)};
    const double deep_m = Deepest(first, random_.Uniform(1e-4, 8e-4));
    const Vec3 side = Normalized(Cross(to - from, first.normal));
    std::vector<Vec3> path{Over({from, first.normal}, kAbove_m)};
    const double length_m = std::max(Norm(to - from), 1e-4);
    const int ticks = std::clamp(static_cast<int>(length_m / 6e-5), 100, 400);
    for (int n = 1; n <= ticks; ++n) {
      const double s = static_cast<double>(n) / ticks, weave_m = 4e-4 * std::sin(0.1 * n);
      const Foot foot{from + s * (to - from) + weave_m * side, first.normal};
      Follow(foot, std::min(1.0, n / 50.0) * deep_m, 3e-4, path);
    }
    Go(Over({to, first.normal}, kAbove_m), 0.1, path);
    return path;
  }

  std::vector<Vec3> ThroughCorner() {
    const Vec3 corner = corners_[AnyTriangle()][random_.Next() % 3];
    Vec3 normal;
    for (const Corners& c : corners_) {
      if (Norm(support::NearestOnTriangle(c, corner) - corner) < 1e-9) normal = normal + NormalOf(c);
    }
    const Foot foot{corner, Normalized(normal)};
    const Vec3 under = Over(foot, -Deepest(foot, random_.Uniform(1e-4, 8e-4)));
    const Vec3 random = random_.InBox(1);
    const Vec3 along = Normalized(random - Dot(random, foot.normal) * foot.normal);
    const double half_m = radius_m_ + random_.Uniform(2e-3, 6e-3), speed_m_s = 0.03 * std::exp(random_.Uniform(0, 2.5));
    std::vector<Vec3> path{under - half_m * along};
    Go(under + half_m * along, speed_m_s, path);
    for (std::size_t k = 1; k + 1 < path.size(); ++k)
      path[k] = path[k] + 0.3 * Tremor(static_cast<int>(k)) * foot.normal;
    return path;
  }

  Surface surface_;
  const Object& built_;
  std::vector<Corners> corners_;
  BallOracle oracle_;
  double radius_m_;
  StrokeStyle style_;
  Random random_;
};

// A pen that leans, its tip a ball or a point: the centre of the ball is where it should be.
class LeaningPen {
 public:
  LeaningPen(const Scene& scene, double radius_m) : scene_(scene), radius_m_(radius_m) {
    config_.delay_s = config_.coil_lag_s = config_.predict_max_s = config_.ramp_s = 0;
    input_.limit = test::UsualLimit();
    input_.tracked = true;
    input_.axis_base = base::Normalized({0.3, -0.2, -0.9});
    Enter();
  }
  void Enter() {
    state = {};
    EnterScene(scene_, state);
    moved_ = false;
  }
  void PutCentre(const Vec3& centre) {
    const Vec3 tip = centre + radius_m_ * input_.axis_base;
    input_.velocity_base_m_s = moved_ ? (1 / input_.dt_s) * (tip - input_.device_point_base_m) : Vec3{};
    input_.device_point_base_m = tip;
    input_.t_ns += 1'000'000;
    moved_ = true;
  }
  void Step() { haptics::Step(config_, scene_, input_, state, output); }

  State state;
  Output output;

 private:
  const Scene& scene_;
  double radius_m_;
  bool moved_ = false;
  Config config_;
  Input input_;
};

// Strokes of at least so many ticks in one style, judged. `step(pen)` calls pen.Step().
template <class StepPen>
BallVerdict JudgeStrokes(const InputObject& object, double radius_m, StrokeStyle style, std::uint64_t ticks,
                         std::uint64_t seed, StepPen&& step) {
  const Scene scene = Built(BallScene(object, radius_m));
  TipStrokes strokes(object, scene, radius_m, style, seed);
  LeaningPen pen(scene, radius_m);
  BallVerdict sum;
  while (sum.ticks < ticks) {
    const std::vector<Vec3> path = strokes.Next();
    if (path.empty()) break;
    pen.Enter();
    BallJudge judge(CornersOf(object), radius_m);
    for (const Vec3& centre : path) {
      pen.PutCentre(centre);
      step(pen);
      judge.Judge(centre, pen.state, pen.output);
    }
    sum.Add(judge.verdict);
  }
  return sum;
}

}  // namespace omni::haptics
