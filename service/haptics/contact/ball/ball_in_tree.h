// The bodies of ball_proxy.h's templates: include this where a view is instantiated, once per view.
#pragma once

#include "service/haptics/contact/ball/ball_near.h"

namespace omni::haptics {

// Successive straight moves: each towards the nearest point that the surfaces touched now allow, until another surface
// is hit   (12.2) to (12.5).
template <TreeView View>
class BallDescent {
 public:
  BallDescent(const View& view, std::uint32_t root, double radius_m, const Vec3& target, const Vec3& centre) noexcept
      : view_(view),
        root_(root),
        radius_m_(radius_m),
        margin_m_(kBallMargin * radius_m),
        target_(target),
        centre_(centre),
        span_m_(std::max(radius_m, 1e-3)) {}

  const Vec3& centre() const noexcept { return centre_; }

  // `expected`: how far the ball will probably move.
  BallContact Run(const Vec3& expected) noexcept {
    const double expected_m = Norm(expected);
    if (expected_m > 0) span_m_ = std::max(1.5 * expected_m, 0.02 * radius_m_);
    if (!Gather(expected)) return Held();
    for (int step = 0; step < kMaxBallSteps && query_count_ < kMaxBallQueries; ++step) {
      FindTouching();
      const NearestInside next = Next();
      RememberFaces(next);
      const bool slides = next.active_count > 0;
      if (Norm(next.point) <= (slides ? 0.5 * margin_m_ : 0)) return Contact(next, true);
      const Vec3 move = slides ? Stride(next) : next.point;
      const double known = Limit(move);  // what is left of the gathered region
      if (known < 1 && known * Norm(move) < margin_m_ && !Gather(move)) return Held();
      const double t = Sweep(move, Limit(move));
      centre_ = t == 1 && !slides ? target_ : centre_ + t * move;
      if (t > 0) continue;
      if (overshot_ || !slides) return Contact(next, false);
      overshot_ = true;  // a lengthened stride ran into another touched surface: retry without
    }
    FindTouching();
    if (touching_ == 0) Fall();
    return Contact(Next(), false);
  }

 private:
  // The last move of a tick that ran out of steps: strides around a rim leave it, and a ball that ends above it would
  // have no contact.
  void Fall() noexcept {
    const Vec3 move = target_ - centre_;
    if (move == Vec3{} || (Limit(move) < 1 && !Gather(move))) return;
    const double t = Sweep(move, Limit(move));
    centre_ = t == 1 ? target_ : centre_ + t * move;
    FindTouching();
  }

  // Finds all triangles that the ball could touch on its way along `move`, at least along its first part.
  bool Gather(const Vec3& move) noexcept {
    constexpr int kTries = 8;
    const double length_m = Norm(move);
    double share = length_m > span_m_ ? span_m_ / length_m : 1;
    for (int k = 0; k < kTries; ++k, share *= 0.25) {
      gathered_at_ = centre_ + (0.5 * share) * move;
      reach_m_ = 0.7 * share * length_m + 4 * margin_m_;
      const bool complete = GatherNear(view_, root_, gathered_at_, radius_m_ + reach_m_, near_);
      query_count_ += static_cast<int>(near_.count / kLeafSize);
      if (!complete) continue;
      span_m_ *= 2;
      return true;
    }
    return false;
  }

  // The part of `move` along which all triangles that the ball could touch are known: inside the sphere they were
  // gathered in.
  double Limit(const Vec3& move) const noexcept {
    const Vec3 way = centre_ - gathered_at_;
    const double radius_m = reach_m_ - margin_m_, out = Dot(way, move), squared = SquaredNorm(move);
    const double root = std::sqrt(std::max(out * out + squared * (radius_m * radius_m - SquaredNorm(way)), 0.0));
    return std::clamp((root - out) / squared, 0.0, 1.0);
  }

  // (12.2) Faces at their distance, edges and vertices a little nearer.
  void FindTouching() noexcept {
    touching_ = 0;
    const Vec3 way = centre_ - gathered_at_;
    for (std::size_t i = 0; i < near_.count; ++i) {
      BallNeighbour& neighbour = near_.of[i];
      if (neighbour.AtLeast(way) > radius_m_ + 0.5 * margin_m_) continue;
      ++query_count_;
      const ClosestPoint closest = ClosestOnTriangle(view_.TriangleCorners(neighbour.triangle), centre_);
      const double distance_m = std::sqrt(closest.distance_squared);
      const double kept_m = IsOnFace(neighbour.triangle, closest) ? radius_m_ : radius_m_ - margin_m_;
      if (distance_m > kept_m + 0.5 * margin_m_) continue;
      const Vec3 normal =
          distance_m > 0 ? (1 / distance_m) * (centre_ - closest.point) : FaceNormal(view_, neighbour.triangle);
      AddTouching({normal, kept_m - distance_m}, {neighbour.triangle, closest, normal, 0});
    }
  }

  // A face that has just held the ball holds it up to its rim: otherwise, where walls meet over the edges between
  // coplanar triangles, the ball would be pushed off a face onto an edge and sink back.
  bool IsOnFace(std::uint32_t triangle, const ClosestPoint& closest) const noexcept {
    return closest.feature == Feature::kFace || std::find(faces_.begin(), faces_.end(), triangle) != faces_.end();
  }

  void RememberFaces(const NearestInside& next) noexcept {
    const std::array<std::uint32_t, kMaxActive> last = faces_;
    faces_.fill(kNoIndex);
    for (std::size_t k = 0; k < static_cast<std::size_t>(next.active_count); ++k) {
      const BallTouch& touch = touches_[static_cast<std::size_t>(next.active[k])];
      const bool held = std::find(last.begin(), last.end(), touch.triangle) != last.end();
      if (held || touch.at.feature == Feature::kFace) faces_[k] = touch.triangle;
    }
  }

  // The same direction twice (both faces of an edge) counts once. With no room left, the least restrictive one is
  // dropped.
  void AddTouching(const HalfSpace& space, const BallTouch& touch) noexcept {
    constexpr double kSameDirection = 1 - 1e-10;
    const Vec3 goal = target_ - centre_;
    std::size_t at = touching_;
    for (std::size_t k = 0; k < touching_; ++k) {
      if (Dot(spaces_[k].normal, space.normal) < kSameDirection) continue;
      if (spaces_[k].offset >= space.offset) return;
      at = k;
    }
    if (at == kMaxBallTouching) {
      at = 0;
      for (std::size_t k = 1; k < touching_; ++k) {
        if (Dot(spaces_[k].normal, goal) > Dot(spaces_[at].normal, goal)) at = k;
      }
      if (Dot(spaces_[at].normal, goal) <= Dot(space.normal, goal)) return;
    }
    spaces_[at] = space;
    touches_[at] = touch;
    touching_ = std::max(touching_, at + 1);
  }

  // (12.4) Squeezed between walls the ball may slide, but not out of them.
  NearestInside Next() noexcept {
    const double tolerance_m = 1e-4 * margin_m_;
    const std::span<const HalfSpace> spaces(spaces_.data(), touching_);
    const NearestInside next = NearestInHalfSpaces(target_ - centre_, spaces, tolerance_m);
    if (next.feasible) return next;
    for (std::size_t k = 0; k < touching_; ++k) spaces_[k].offset = std::min(spaces_[k].offset, 0.0);
    const NearestInside slide = NearestInHalfSpaces(target_ - centre_, spaces, tolerance_m);
    return slide.feasible ? slide : Stuck();
  }

  // Rounding left no move: held by the most opposing surface.
  NearestInside Stuck() const noexcept {
    NearestInside stuck;
    stuck.active_count = 1;
    for (std::size_t k = 1; k < touching_; ++k) {
      const auto most = static_cast<std::size_t>(stuck.active[0]);
      const Vec3 goal = target_ - centre_;
      if (Dot(spaces_[k].normal, goal) < Dot(spaces_[most].normal, goal)) stuck.active[0] = static_cast<int>(k);
    }
    return stuck;
  }

  // (12.5) On round edges and corners slides would get shorter by a factor each time; where two faces meet in a very
  // blunt groove they would turn back and forth.
  Vec3 Stride(const NearestInside& next) noexcept {
    const Vec3 slide = next.point, last = last_slide_;
    if (Norm(slide) < 4 * margin_m_) return slide;  // little more than being pushed out
    last_slide_ = slide;
    const bool turned = Dot(slide, last) < -0.5 * Norm(slide) * Norm(last);
    stride_ = turned ? 0.5 * stride_ : 1;
    overshot_ = overshot_ || turned;
    const auto active = static_cast<std::size_t>(next.active[0]);
    const Rim last_rim = last_rim_;
    last_rim_ = next.active_count == 1 ? RimOf(touches_[active]) : Rim{};
    if (overshot_ || last_rim_.from == kNoIndex || !(last_rim_ == last_rim)) return stride_ * slide;
    return AroundRim(spaces_[active].normal, touches_[active].at.point, slide);
  }

  // The edge that is touched, or the vertex twice; none for a face.
  struct Rim {
    std::uint32_t from = kNoIndex, to = kNoIndex;
    bool operator==(const Rim&) const = default;
  };
  Rim RimOf(const BallTouch& touch) const noexcept {
    if (touch.at.feature == Feature::kFace) return {};
    const auto& vertex = view_.GetTriangle(touch.triangle).vertex;
    const std::uint32_t a = vertex[touch.at.index];
    const std::uint32_t b = touch.at.feature == Feature::kEdge ? vertex[(touch.at.index + 1) % 3] : a;
    return {std::min(a, b), std::max(a, b)};
  }

  // Lengthens the part of a slide that goes around the rim so that the way from its end straight to the target meets
  // the rim's circle at the place that is nearest to the target: k = kept / height. A target over the rim or beyond it
  // makes the ball leave: it does so in long steps, too.
  Vec3 AroundRim(const Vec3& normal, const Vec3& place, const Vec3& slide) const noexcept {
    constexpr double kLongest = 8, kFarthest = 0.25;  // times the slide, of the radius
    const double height_m = Dot(normal, target_ - place), kept_m = radius_m_ - margin_m_;
    const Vec3 edge = Normalized(view_.VertexPosition(last_rim_.to) - view_.VertexPosition(last_rim_.from));
    const Vec3 around = slide - Dot(slide, normal) * normal - Dot(slide, edge) * edge;
    const double times = std::min(kept_m / std::max(height_m, kept_m / kLongest),
                                  kFarthest * kept_m / std::max(Norm(around), margin_m_));
    return times > 1 ? slide + (times - 1) * around : slide;
  }

  // (12.3)
  double Sweep(const Vec3& move, double limit) noexcept {
    const double hard_m = radius_m_ - 2 * margin_m_, over_m = radius_m_ - 1.5 * margin_m_;
    double t = limit;
    const Vec3 way = centre_ - gathered_at_;
    for (std::size_t i = 0; i < near_.count && t > 0; ++i) {
      const BallNeighbour& neighbour = near_.of[i];
      if (std::min(neighbour.AtLeast(way), neighbour.AtLeast(way + t * move)) > over_m) continue;
      ++query_count_;
      const Corners corners = view_.TriangleCorners(neighbour.triangle);
      if (!StaysOver(corners, t * move, over_m)) t = FirstTouch(corners, centre_, move, hard_m, 0.25 * margin_m_, t);
    }
    return t;
  }

  // Over the triangle's plane, before the move and after it: then the plane is not met, let alone the triangle.
  bool StaysOver(const Corners& corners, const Vec3& move, double over_m) const noexcept {
    const Vec3 area = AreaVector(corners);
    const double before = ScaledHeight(corners, area, centre_), after = before + Dot(area, move);
    const double least = before * after > 0 ? std::min(before * before, after * after) : 0;
    return least > over_m * over_m * SquaredNorm(area);
  }

  BallContact Contact(const NearestInside& next, bool settled) const noexcept {
    BallContact contact;
    contact.settled = settled;
    const Vec3 push = centre_ - target_;
    const double push_m = Norm(push);
    if (push == Vec3{}) return contact;
    const auto shares = Multipliers(next, {spaces_.data(), touching_}, push);
    for (std::size_t k = 0; k < static_cast<std::size_t>(next.active_count); ++k) {
      if (!(shares[k] > 0)) continue;
      BallTouch& touch = contact.touches[static_cast<std::size_t>(contact.touch_count++)];
      touch = touches_[static_cast<std::size_t>(next.active[k])];
      touch.share = shares[k] / push_m;
    }
    if (contact.touch_count == 0) contact.touches[static_cast<std::size_t>(contact.touch_count++)] = Beside(push);
    contact.felt = contact.touches[0].share > 0;
    return contact;
  }

  // No touched surface holds the centre, yet it is not at the device point: rounding holds it, or it is still moving
  // through free space. The most opposing surface, else the nearest, without a share.
  BallTouch Beside(const Vec3& push) const noexcept {
    BallTouch most;
    for (std::size_t k = 0; k < touching_; ++k) {
      const double share = std::max(0.0, Dot(touches_[k].normal, push) / Norm(push));
      if (most.triangle != kNoIndex && share <= most.share) continue;
      most = touches_[k];
      most.share = share;
    }
    return touching_ > 0 ? most : NearestTouch(0);
  }

  BallTouch NearestTouch(double share) const noexcept {
    const NearestResult nearest = NearestInTree(view_, root_, centre_);
    return {nearest.triangle, nearest.closest, Normalized(centre_ - nearest.closest.point), share};
  }

  // Touched in too many places to know what a move would hit: held, unless it is clearly free.
  BallContact Held() noexcept {
    const bool is_free = NearestInTree(view_, root_, target_, radius_m_ - margin_m_).triangle == kNoIndex &&
                         CrossingInTree(view_, root_, centre_, target_, true).triangle == kNoIndex;
    if (is_free) {
      centre_ = target_;
      return {};
    }
    BallContact contact;
    contact.settled = false;
    contact.felt = true;
    contact.touch_count = 1;
    contact.touches[0] = NearestTouch(1);
    return contact;
  }

  const View& view_;
  const std::uint32_t root_;
  const double radius_m_, margin_m_;
  const Vec3 target_;
  Vec3 centre_;
  double span_m_;       // longest move that is gathered for at once
  Vec3 gathered_at_;    // around there, near_ is complete ...
  double reach_m_ = 0;  // ... for a ball whose centre is at most so far away
  BallNear near_;
  int query_count_ = 0;  // triangles checked in this tick, leaves while gathering
  std::array<std::uint32_t, kMaxActive> faces_{kNoIndex, kNoIndex, kNoIndex};  // that held the ball at the last move
  Vec3 last_slide_;
  double stride_ = 1;
  bool overshot_ = false;  // in this tick: no more lengthened strides
  Rim last_rim_;
  std::size_t touching_ = 0;
  std::array<HalfSpace, kMaxBallTouching> spaces_;
  std::array<BallTouch, kMaxBallTouching> touches_;
};

inline constexpr double kFarthestBall_m = 1e6;

// Out of bodies that go through each other: to in front of the nearest face that `p` is behind, and so on from there,
// until it is free.
template <TreeView View, class IsFree>
bool StepOut(const View& view, std::uint32_t root, double radius_m, Vec3 p, const IsFree& is_free,
             Vec3& centre) noexcept {
  constexpr int kMostSteps = 16;
  for (int k = 0; k < kMostSteps; ++k) {
    const NearestResult face = NearestFaceInTree(view, root, p, kFarthestBall_m, {});
    if (face.triangle == kNoIndex) return false;
    p = face.closest.point + 1.01 * radius_m * FaceNormal(view, face.triangle);
    centre = p;
    if (is_free(NearestInTree(view, root, p), p)) return true;
  }
  return false;
}

template <TreeView View>
BallState StartBall(const View& view, std::uint32_t root, Inside inside, double radius_m,
                    const Vec3& device_point_m) noexcept {
  constexpr int kTries = 48;  // twice as far each time: 1e-6 m to out of any scene
  if (!IsWithin(device_point_m, kFarthestBall_m)) return {};
  const NearestResult nearest = NearestInTree(view, root, device_point_m);
  const auto is_free = [&](const NearestResult& at, const Vec3& centre) noexcept {
    const double kept_m = radius_m * (1 - kBallMargin);
    return at.closest.distance_squared >= kept_m * kept_m && !IsInsideBy(inside, view, root, at, centre);
  };
  if (is_free(nearest, device_point_m)) return {device_point_m, device_point_m};
  Vec3 centre;
  if (inside == Inside::kByWinding && IsInsideBy(inside, view, root, nearest, device_point_m) &&
      StepOut(view, root, radius_m, device_point_m, is_free, centre)) {
    return {centre, device_point_m};
  }
  const ClosestPoint& foot = nearest.closest;
  Vec3 out = Normalized(device_point_m - foot.point);
  if (!(foot.distance_squared > 1e-18))
    out = Pseudonormal(view, nearest.triangle, foot.feature, foot.index);
  else if (IsInsideBy(inside, view, root, nearest, device_point_m))
    out = -out;
  double distance_m = radius_m;
  for (int k = 0; k < kTries; ++k, distance_m *= 2) {
    centre = foot.point + distance_m * out;
    if (is_free(NearestInTree(view, root, centre), centre)) break;
  }
  return {centre, device_point_m};
}

template <TreeView View>
BallContact FollowBall(const View& view, std::uint32_t root, double radius_m, const Vec3& device_point_m,
                       BallState& state) noexcept {
  if (!IsWithin(device_point_m, kFarthestBall_m)) return {};
  BallDescent<View> descent(view, root, radius_m, device_point_m, state.centre_m);
  const BallContact contact = descent.Run(device_point_m - state.device_point_m);
  state = {descent.centre(), device_point_m};
  return contact;
}

}  // namespace omni::haptics
