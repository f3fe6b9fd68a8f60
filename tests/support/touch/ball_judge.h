// A pen whose ball slides over a body, through haptics::Step, and a judge of the results: the ball's centre is outside
// by the winding number, the force pushes the tip out, and there is one exactly where the tip is in the body.
#pragma once

#include <vector>

#include "service/haptics/contact/ball/ball_proxy.h"
#include "service/haptics/contact/frame.h"
#include "service/haptics/geometry/topology.h"
#include "tests/haptics/oracle.h"
#include "tests/support/surface_queries.h"
#include "tests/support/touch/nearest_on_triangle.h"

namespace omni::haptics {

inline SceneInput BallScene(InputObject object, double radius_m) {
  SceneInput input = SceneOf(std::move(object));
  input.materials[0].static_friction = input.materials[0].dynamic_friction = input.materials[0].damping_Ns_m = 0;
  input.tip_radius_m = radius_m;
  return input;
}

inline std::vector<Corners> CornersOf(const Surface& surface, const Object& object) {
  std::vector<Corners> corners;
  for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
    corners.push_back(surface.TriangleCorners(object.first_triangle + t));
  }
  return corners;
}

inline std::vector<Corners> CornersOf(const InputObject& object) {
  std::vector<Corners> corners;
  for (const auto& [a, b, c] : object.triangles) {
    corners.push_back({object.vertices_base_m[a], object.vertices_base_m[b], object.vertices_base_m[c]});
  }
  return corners;
}

// Distance and side by sums over all triangles. Between the sums: a ball with the distance at the last place as radius
// contains no surface, so all points in it are on the same side; and only triangles that were near there can be near.
class BallOracle {
 public:
  explicit BallOracle(std::vector<Corners> corners) : corners_(std::move(corners)) {
    for (const Corners& c : corners_) {
      const Vec3 middle = (1.0 / 3) * (c[0] + c[1] + c[2]);
      const double radius_m = std::max({Norm(c[0] - middle), Norm(c[1] - middle), Norm(c[2] - middle)});
      all_.push_back({c, middle, radius_m});
    }
  }

  double Distance(const Vec3& p) {
    if (!(Norm(p - gathered_at_) < 0.5 * kGather_m)) Gather(p);
    double best = 0.25 * kGather_m * kGather_m;
    double best_m = std::sqrt(best);
    for (const Bounded& b : near_) {
      const double beyond_m = best_m + b.radius_m;
      if (SquaredNorm(p - b.middle) >= beyond_m * beyond_m) continue;
      best = std::min(best, SquaredDistance(b.corners, p));
      best_m = std::sqrt(best);
    }
    return best_m;  // at most half of kGather_m
  }
  bool IsInside(const Vec3& p) {
    if (Norm(p - counted_at_) < 0.999 * clear_m_) return inside_;
    counted_at_ = p;
    clear_m_ = Distance(p);
    inside_ = Winding(p) > 0.5;
    return inside_;
  }
  // Sum of solid angles over 4 pi   [van Oosterom & Strackee 1983]
  double Winding(const Vec3& p) const {
    double sum = 0;
    for (const Corners& corners : corners_) {
      const Vec3 a = corners[0] - p, b = corners[1] - p, c = corners[2] - p;
      const double la = Norm(a), lb = Norm(b), lc = Norm(c);
      sum += std::atan2(Dot(a, Cross(b, c)), la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb);
    }
    return sum / (2 * std::numbers::pi);
  }

 private:
  static constexpr double kGather_m = 0.012;
  static double SquaredDistance(const Corners& corners, const Vec3& p) {
    return SquaredNorm(support::NearestOnTriangle(corners, p) - p);
  }
  void Gather(const Vec3& p) {
    gathered_at_ = p;
    near_.clear();
    for (const Bounded& b : all_) {
      const double beyond_m = kGather_m + b.radius_m;
      if (SquaredNorm(p - b.middle) >= beyond_m * beyond_m) continue;
      if (SquaredDistance(b.corners, p) < kGather_m * kGather_m) near_.push_back(b);
    }
  }

  struct Bounded {
    Corners corners;
    Vec3 middle;  // of a ball around it
    double radius_m;
  };
  std::vector<Corners> corners_;
  std::vector<Bounded> all_, near_;
  Vec3 gathered_at_{1e9, 0, 0}, counted_at_{1e9, 0, 0};
  double clear_m_ = 0;
  bool inside_ = false;
};

// Results of the judged ticks.
struct BallVerdict {
  std::uint64_t ticks = 0, touching = 0, judged = 0;  // judged: the force was not fading from one place to another
  std::uint64_t inside = 0;    // the ball's centre is in the body; without a contact the ball is at the tip
  std::uint64_t inverted = 0;  // the force pulls the tip to a place in the body, or towards it
  double least_gap = 1;        // between centre and surface, less the radius, in radii; of a point: 1
  // In runs of kRun ticks and more: deeper than kSeen_m in the body without force; further than that off it with one.
  std::uint64_t missed = 0, false_contacts = 0;
  std::uint64_t through = 0;  // not false: a part of the body is between the tip and what holds it, as (2.3) says
  std::uint64_t longest_inside = 0, falls = 0;  // ticks in a row, and how often

  void Add(const BallVerdict& other) {
    ticks += other.ticks;
    touching += other.touching;
    judged += other.judged;
    inside += other.inside;
    inverted += other.inverted;
    least_gap = std::min(least_gap, other.least_gap);
    missed += other.missed;
    false_contacts += other.false_contacts;
    through += other.through;
    longest_inside = std::max(longest_inside, other.longest_inside);
    falls += other.falls;
  }
};

inline const ContactState* ContactWith(std::uint32_t object, const State& state) {
  for (const ContactState& contact : state.contacts) {
    if (contact.active && contact.object == object) return &contact;
  }
  return nullptr;
}

inline constexpr std::uint64_t kRun = 3;

// Adds the ticks of runs of kRun and more to `ticks`; `run`: how long the present one is.
inline void CountRun(bool now, std::uint64_t& run, std::uint64_t& ticks) {
  run = now ? run + 1 : 0;
  ticks += run == kRun ? kRun : (run > kRun ? 1 : 0);
}

// Judges one object of a scene without friction.
class BallJudge {
 public:
  BallJudge(std::vector<Corners> corners, double radius_m, std::uint32_t object = 0)
      : oracle_(std::move(corners)), about_tip_(oracle_), radius_m_(radius_m), object_(object) {}

  // The tip and the result; the object's placement.
  void Judge(const Vec3& tip_base_m, const State& state, const Output& output, const Frame& frame = {}) {
    ++verdict.ticks;
    const Vec3 tip = frame.ToRest(tip_base_m);
    const ContactState* contact = ContactWith(object_, state);
    const bool swapped = swaps_;  // the force of the last tick of a swap is still a mixture
    swaps_ = contact != nullptr && contact->swap_left_s > 0;
    if (contact != nullptr && contact->popped) return;
    const Vec3 centre = contact != nullptr ? contact->held_m : tip;
    const bool inside = IsIn(centre);
    verdict.inside += inside;
    run_ = inside ? run_ + 1 : 0;
    verdict.falls += run_ == 1;
    verdict.longest_inside = std::max(verdict.longest_inside, run_);
    if (radius_m_ > 0) verdict.least_gap = std::min(verdict.least_gap, oracle_.Distance(centre) / radius_m_ - 1);
    CountRuns(tip, centre, output);
    for (int k = 0; k < output.contact_count; ++k) {
      const Contact& felt = output.contacts[static_cast<std::size_t>(k)];
      if (felt.object != object_ || !(Norm(felt.force_base_N) > kLeast_N)) continue;
      ++verdict.touching;
      if (swaps_ || swapped) continue;
      ++verdict.judged;
      verdict.inverted += IsInverted(tip, centre, felt, frame.RestDirection(felt.force_base_N));
    }
  }

  BallVerdict verdict;

 private:
  static constexpr double kLeast_N = 1e-3;
  static constexpr double kSeen_m = 20e-6;  // a missed or false contact within it is not felt
  static constexpr double kRound_m = 1e-6;  // a point on the surface may lie so far in it

  bool IsIn(const Vec3& p) { return oracle_.IsInside(p) && (radius_m_ > 0 || oracle_.Distance(p) > kRound_m); }

  // Above the surface, in front of all of the ball; < 0 in it.
  double Gap(const Vec3& p) {
    const double distance_m = about_tip_.Distance(p);
    return (about_tip_.IsInside(p) ? -distance_m : distance_m) - radius_m_;
  }
  // The straight way from what holds the tip leads through the body, however thin it is there: from within 5 um of it,
  // for a place on an edge or a corner may belong to either face.
  bool IsBetween(const Vec3& held, const Vec3& tip) {
    for (int n = 0; n < 27; ++n) {
      const Vec3 from = held + 5e-6 * Vec3{n % 3 - 1.0, n / 3 % 3 - 1.0, n / 9 % 3 - 1.0};
      const double way_m = Norm(tip - from);
      for (double s_m = 1e-6; s_m < way_m; s_m *= 1.2) {
        if (Gap(from + (s_m / way_m) * (tip - from)) < -1e-7) return true;
      }
    }
    return false;
  }
  void CountRuns(const Vec3& tip, const Vec3& held, const Output& output) {
    const bool felt = std::any_of(output.contacts.begin(), output.contacts.begin() + output.contact_count,
                                  [this](const Contact& c) { return c.object == object_ && Norm(c.force_base_N) > 0; });
    // The side, which costs more than the distance, only where it decides.
    const double distance_m = about_tip_.Distance(tip);
    const bool missed =
        !felt && (distance_m < radius_m_ - kSeen_m || (distance_m + radius_m_ > kSeen_m && about_tip_.IsInside(tip)));
    const bool is_free = felt && distance_m > radius_m_ + kSeen_m && !about_tip_.IsInside(tip);
    const bool through = is_free && IsBetween(held, tip);
    CountRun(missed, missed_run_, verdict.missed);
    CountRun(is_free && !through, false_run_, verdict.false_contacts);
    verdict.through += through;
  }
  bool IsInverted(const Vec3& tip, const Vec3& centre, const Contact& felt, const Vec3& force_N) {
    const Vec3 rest = tip - felt.gap_m * Normalized(force_N);
    return IsIn(rest) || !(Dot(force_N, centre - tip) > 0);
  }

  BallOracle oracle_, about_tip_;  // the latter for places around the tip: each remembers where it was last
  double radius_m_;
  std::uint32_t object_;
  std::uint64_t run_ = 0, missed_run_ = 0, false_run_ = 0;
  bool swaps_ = false;
};

struct Strokes {  // 0: another one for every stroke
  double step_m = 0, press_m = 0;
};

// Path of the tip in a hand: over the surface and around its edges with a varying press, with noise; now and then off
// the body, across a corner of it, or at rest.
class SlidingHand {
 public:
  SlidingHand(const Scene& scene, double radius_m, std::uint64_t seed, const Strokes& strokes = {})
      : surface_(scene, {}), object_(scene.objects()[0]), radius_m_(radius_m), strokes_(strokes), random_(seed) {
    const Corners first = surface_.TriangleCorners(object_.first_triangle);
    foot_ = (1.0 / 3) * (first[0] + first[1] + first[2]);
    normal_ = FaceNormal(surface_, object_.first_triangle);
    tip_ = foot_ + 0.01 * normal_;
    Begin();
  }

  Vec3 Next() {
    if (left_-- == 0) Begin();
    Walk();
    const double press_m = press_m_ * (0.7 + 0.3 * std::sin(0.01 * left_));
    const Vec3 goal = foot_ + (lifted_ ? 2 * radius_m_ + 1e-3 : radius_m_ - press_m) * normal_;
    const Vec3 way = goal - tip_;
    tip_ = Norm(way) > step_m_ ? tip_ + (step_m_ / Norm(way)) * way : goal;
    return tip_ + random_.InBox(noise_m_);
  }

 private:
  void Begin() {
    left_ = 100 + static_cast<int>(random_.Next() % 900);
    step_m_ = strokes_.step_m > 0 ? strokes_.step_m : 2e-5 * std::exp(random_.Uniform(0, 3.5));     // 20 to 660 mm/s
    press_m_ = strokes_.press_m > 0 ? strokes_.press_m : 2e-4 * std::exp(random_.Uniform(0, 2.5));  // 0.2 to 2.4 mm
    noise_m_ = random_.Next() % 2 == 0 ? 0 : 2e-5;
    lifted_ = random_.Next() % 8 == 0;
    rests_ = random_.Next() % 8 == 0;
    heading_ = random_.InBox(1);
    if (random_.Next() % 4 != 0) return;  // else to another place, straight through everything between
    const auto t = static_cast<std::uint32_t>(random_.Next() % object_.triangle_count);
    const Corners corners = surface_.TriangleCorners(object_.first_triangle + t);
    const double u = random_.Uniform(0, 1), v = random_.Uniform(0, 1 - u);
    const Vec3 there = (1 - u - v) * corners[0] + u * corners[1] + v * corners[2];
    if (Norm(there - foot_) < 0.006) foot_ = there;
  }
  // The foot point continues over the surface, around edges and through grooves.
  void Walk() {
    heading_ = Normalized(heading_ + random_.InBox(0.05));
    const double step_m = rests_ ? 0 : step_m_;
    const Vec3 along = Normalized(heading_ - Dot(heading_, normal_) * normal_);
    const NearestResult next = support::NearestPoint(surface_, object_, foot_ + step_m * (along - 0.5 * normal_));
    foot_ = next.closest.point;
    normal_ = FaceNormal(surface_, next.triangle);
  }

  Surface surface_;
  const Object& object_;
  double radius_m_;
  Strokes strokes_;
  Random random_;
  Vec3 foot_, normal_, tip_, heading_;
  int left_ = 0;
  double step_m_ = 0, press_m_ = 0, noise_m_ = 0;
  bool lifted_ = false, rests_ = false;
};

// Slides a ball over a body for a number of ticks.
inline BallVerdict SlideOver(const InputObject& object, double radius_m, std::uint64_t ticks, std::uint64_t seed) {
  Pen pen(Built(BallScene(object, radius_m)));
  SlidingHand hand(pen.scene(), radius_m, seed);
  BallJudge judge(CornersOf(Surface(pen.scene(), {}), pen.scene().objects()[0]), radius_m);
  for (std::uint64_t k = 0; k < ticks; ++k) {
    const Vec3 tip = hand.Next();
    pen.MoveTo(tip);
    judge.Judge(tip, pen.state, pen.output);
  }
  return judge.verdict;
}

}  // namespace omni::haptics
