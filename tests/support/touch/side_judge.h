// Strokes of a pen over bodies whose meshes are broken, through haptics::Step, judged by the formula of the whole body:
// a tip that is in it is held, and one that is outside is not.
#pragma once

#include <vector>

#include "service/haptics/geometry/triangle_math.h"
#include "tests/support/touch/broken_bodies.h"

namespace omni::haptics::broken {

// Ticks; of MISSED and FALSE those from the third in a row on.
struct SideCounts {
  std::uint64_t strokes = 0, ticks = 0, inside = 0, missed = 0, false_contacts = 0;
};

class SideJudge {
 public:
  // `radius_m`: of a ball tip, 0: a point.
  SideJudge(const Broken& broken, double radius_m) : broken_(broken), radius_m_(radius_m) {}

  void Judge(const Vec3& tip, const Output& output) {
    bool held = false;
    for (int k = 0; k < output.contact_count; ++k)
      held = held || Norm(output.contacts[static_cast<std::size_t>(k)].force_base_N) > kLeast_N;
    if (IsAtOpening(tip, held)) {
      missed_ = false_ = 0;
      return;
    }
    ++counts.ticks;
    const double height_m = broken_.height(tip) - radius_m_, slack_m = kSlack_m + broken_.moved_m;
    counts.inside += height_m < -slack_m;
    missed_ = height_m < -slack_m && !held ? missed_ + 1 : 0;
    false_ = height_m > slack_m && held ? false_ + 1 : 0;
    counts.missed += missed_ >= kRow;
    counts.false_contacts += false_ >= kRow;
  }
  void Begin() { missed_ = false_ = fell_ = 0; }

  SideCounts counts;

 private:
  static constexpr double kSlack_m = 20e-6, kLeast_N = 1e-3, kBeside_m = 1e-3;
  static constexpr int kRow = 3;

  // Beside an opening that is wider than 50 um, and after the tip was there until it is outside and free: it may go in,
  // and then feels the walls from within.
  bool IsAtOpening(const Vec3& tip, bool held) {
    double nearest2 = 1;
    for (const Segment& rim : broken_.rims)
      nearest2 = std::min(nearest2, ClosestOnTriangle({rim.a, rim.b, rim.b}, tip).distance_squared);
    const double reach_m = kBeside_m + radius_m_ + std::max(0.0, -broken_.height(tip)) * 2;
    const bool is_near = nearest2 < reach_m * reach_m;
    fell_ = is_near || (fell_ != 0 && (held || broken_.height(tip) < radius_m_ + kSlack_m));
    return fell_ != 0;
  }

  const Broken& broken_;
  double radius_m_;
  int missed_ = 0, false_ = 0, fell_ = 0;
};

// Where the tip goes: towards the surface, along it at some depth, and away again, at 10 to 500 mm/s.
class SideStroke {
 public:
  SideStroke(const Broken& broken, double radius_m, Random& random)
      : height_(broken.height), radius_m_(radius_m), random_(random) {
    const auto& vertices = broken.object.vertices_base_m;
    foot_ = vertices[random.Next() % vertices.size()];
    Put(foot_ + random.InBox(1e-3));
    heading_ = random.InBox(1);
    step_m_ = 1e-5 * std::exp(random.Uniform(0, 4));
    depth_m_ = 6e-5 * std::exp(random.Uniform(0, 3.5));
    slides_ = 50 + static_cast<int>(random.Next() % 300);
    starts_inside_ = random.Next() % 8 == 0;
    tip_ = foot_ + (radius_m_ + (starts_inside_ ? -depth_m_ : 3e-3)) * normal_;
    lands_ = starts_inside_ ? 0 : static_cast<int>((3e-3 + depth_m_) / step_m_) + 1;
    leaves_ = static_cast<int>((2e-3 + depth_m_) / step_m_) + 1;
  }

  int ticks() const { return lands_ + slides_ + leaves_; }
  const Vec3& tip() const { return tip_; }

  const Vec3& Next() {
    ++tick_;
    if (tick_ > lands_ && tick_ <= lands_ + slides_) Walk();
    const bool in = tick_ <= lands_ + slides_;
    const Vec3 way = foot_ + (radius_m_ + (in ? -depth_m_ : 2e-3)) * normal_ - tip_;
    tip_ = Norm(way) > step_m_ ? tip_ + (step_m_ / Norm(way)) * way : tip_ + way;
    return tip_;
  }

 private:
  Vec3 Gradient(const Vec3& p) const {
    constexpr double kH = 1e-7;
    const auto slope = [&](const Vec3& by) { return height_(p + by) - height_(p - by); };
    return Normalized(Vec3{slope({kH, 0, 0}), slope({0, kH, 0}), slope({0, 0, kH})});
  }
  void Put(Vec3 p) {
    for (int k = 0; k < 4; ++k) p = p - height_(p) * Gradient(p);
    foot_ = p;
    normal_ = Gradient(p + 1e-6 * Gradient(p));
  }
  void Walk() {
    heading_ = Normalized(heading_ + 0.05 * random_.InBox(1));
    Put(foot_ + step_m_ * Normalized(heading_ - Dot(heading_, normal_) * normal_));
  }

  const Height& height_;
  double radius_m_;
  Random& random_;
  Vec3 foot_, normal_, heading_, tip_;
  double step_m_ = 0, depth_m_ = 0;
  int lands_ = 0, slides_ = 0, leaves_ = 0, tick_ = 0;
  bool starts_inside_ = false;
};

// Strokes over one body, which appears to no pen: the first tick of some strokes is inside.
inline SideCounts Stroke(const Broken& broken, double radius_m, int strokes, std::uint64_t seed) {
  SceneInput input = SceneOf(broken.object);
  input.materials[0].static_friction = input.materials[0].dynamic_friction = input.materials[0].damping_Ns_m = 0;
  input.tip_radius_m = radius_m;
  Pen pen(Built(input));
  SideJudge judge(broken, radius_m);
  Random random(seed);
  for (int k = 0; k < strokes; ++k) {
    SideStroke stroke(broken, radius_m, random);
    for (int away = 0; away < 30; ++away) pen.Lose();
    judge.Begin();
    judge.Judge(stroke.tip(), pen.MoveTo(stroke.tip()));
    for (int tick = 0; tick < stroke.ticks(); ++tick) {
      const Vec3 tip = stroke.Next();
      judge.Judge(tip, pen.MoveTo(tip));
    }
    ++judge.counts.strokes;
  }
  return judge.counts;
}

}  // namespace omni::haptics::broken
