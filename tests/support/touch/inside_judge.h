// On which side of a closed body the tip truly is: crossings of three rays, in double, over the body's triangles alone.
// A judge of contacts with it; shares no formula with what it judges.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "service/haptics/geometry/triangle_math.h"
#include "tests/support/touch/ball_judge.h"

namespace omni::haptics {

class InsideOracle {
 public:
  explicit InsideOracle(std::vector<Corners> corners) : corners_(std::move(corners)) {
    for (const Corners& c : corners_) {
      lower_ = Min(lower_, Min(Min(c[0], c[1]), c[2]));
      upper_ = Max(upper_, Max(Max(c[0], c[1]), c[2]));
    }
    const Vec3 d = upper_ - lower_;
    cell_m_ = std::max({d.x, d.y, d.z}) / kCells + 1e-12;
    // Directions in which no mesh made by formula has edges.
    const std::array<Vec3, 3> along{Vec3{0.2137, 0.3571, 0.9087}, Vec3{-0.5713, 0.7793, 0.2573},
                                    Vec3{0.8317, -0.1931, 0.5207}};
    for (std::size_t r = 0; r < 3; ++r) rays_[r].Build(along[r], corners_);
    near_.resize(std::size_t{kCells} * kCells * kCells);
    for (std::uint32_t t = 0; t < corners_.size(); ++t) {
      const Corners& c = corners_[t];
      ForCells(Min(Min(c[0], c[1]), c[2]), Max(Max(c[0], c[1]), c[2]), [&](std::size_t cell) {
        near_[cell].push_back(t);
        return false;
      });
    }
  }

  // How many times the body lies around the point: 1 inside, 0 outside, others where it crosses itself.
  int Winding(const Vec3& p) const {
    std::array<int, 3> n{rays_[0].Winding(p), rays_[1].Winding(p), rays_[2].Winding(p)};
    std::sort(n.begin(), n.end());
    return n[1];
  }
  bool IsInside(const Vec3& p) const { return Winding(p) != 0; }

  bool IsNear(const Vec3& p, double within_m) const {
    const Vec3 r{within_m, within_m, within_m};
    return ForCells(p - r, p + r, [&](std::size_t cell) {
      return std::any_of(near_[cell].begin(), near_[cell].end(), [&](std::uint32_t t) {
        return ClosestOnTriangle(corners_[t], p).distance_squared < within_m * within_m;
      });
    });
  }

 private:
  static constexpr int kCells = 48;

  // Triangles seen along one direction, in squares across it.
  class Rays {
   public:
    void Build(const Vec3& along, const std::vector<Corners>& corners) {
      w_ = Normalized(along);
      u_ = Normalized(Cross(w_, Vec3{0.37, 0.71, -0.6}));
      v_ = Cross(w_, u_);
      double low_u = 1e30, low_v = 1e30, high = -1e30;
      for (const Corners& c : corners) {
        triangles_.push_back({Turned(c[0]), Turned(c[1]), Turned(c[2])});
        for (const Vec3& p : triangles_.back()) {
          low_u = std::min(low_u, p.x);
          low_v = std::min(low_v, p.y);
        }
      }
      for (const Corners& c : triangles_) {
        for (const Vec3& p : c) high = std::max({high, p.x - low_u, p.y - low_v});
      }
      low_u_ = low_u;
      low_v_ = low_v;
      square_m_ = high / kSquares + 1e-12;
      squares_.resize(std::size_t{kSquares} * kSquares);
      for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
        const Corners& c = triangles_[t];
        const Vec3 low = Min(Min(c[0], c[1]), c[2]), up = Max(Max(c[0], c[1]), c[2]);
        for (int i = Square(low.x - low_u_); i <= Square(up.x - low_u_); ++i) {
          for (int j = Square(low.y - low_v_); j <= Square(up.y - low_v_); ++j) {
            squares_[static_cast<std::size_t>(i * kSquares + j)].push_back(t);
          }
        }
      }
    }

    // Triangles over the point that it sees from inside, less those that it sees from outside.
    int Winding(const Vec3& point) const {
      const Vec3 p = Turned(point);
      if (p.x < low_u_ || p.y < low_v_) return 0;
      const auto i = static_cast<int>((p.x - low_u_) / square_m_), j = static_cast<int>((p.y - low_v_) / square_m_);
      if (i >= kSquares || j >= kSquares) return 0;
      int sum = 0;
      for (const std::uint32_t t : squares_[static_cast<std::size_t>(i * kSquares + j)]) {
        const Corners& c = triangles_[t];
        const double a = Turn(c[1], c[2], p), b = Turn(c[2], c[0], p), d = Turn(c[0], c[1], p);
        const bool left = a > 0 && b > 0 && d > 0, right = a < 0 && b < 0 && d < 0;
        if (!left && !right) continue;
        const double z = (a * c[0].z + b * c[1].z + d * c[2].z) / (a + b + d);
        if (z > p.z) sum += left ? 1 : -1;
      }
      return sum;
    }

   private:
    static constexpr int kSquares = 256;
    static double Turn(const Vec3& a, const Vec3& b, const Vec3& p) {
      return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    }
    Vec3 Turned(const Vec3& p) const { return {Dot(p, u_), Dot(p, v_), Dot(p, w_)}; }
    int Square(double x) const { return std::clamp(static_cast<int>(x / square_m_), 0, kSquares - 1); }

    Vec3 u_, v_, w_;
    double low_u_ = 0, low_v_ = 0, square_m_ = 1;
    std::vector<Corners> triangles_;
    std::vector<std::vector<std::uint32_t>> squares_;
  };

  // True if `found(cell)` is, for a cell that the box overlaps.
  template <class Found>
  bool ForCells(const Vec3& low, const Vec3& up, Found&& found) const {
    const auto cell = [&](double x, double from) {
      return std::clamp(static_cast<int>(std::floor((x - from) / cell_m_)), 0, kCells - 1);
    };
    for (int i = cell(low.x, lower_.x); i <= cell(up.x, lower_.x); ++i) {
      for (int j = cell(low.y, lower_.y); j <= cell(up.y, lower_.y); ++j) {
        for (int k = cell(low.z, lower_.z); k <= cell(up.z, lower_.z); ++k) {
          if (found(static_cast<std::size_t>((i * kCells + j) * kCells + k))) return true;
        }
      }
    }
    return false;
  }

  std::vector<Corners> corners_;
  Vec3 lower_{1e30, 1e30, 1e30}, upper_{-1e30, -1e30, -1e30};
  double cell_m_ = 1;
  std::array<Rays, 3> rays_;
  std::vector<std::vector<std::uint32_t>> near_;
};

// Counts ticks in runs of at least three in which the contact of a point tip is wrong by more than kWithin_m.
class InsideJudge {
 public:
  static constexpr double kWithin_m = 20e-6;

  explicit InsideJudge(std::vector<Corners> corners) : oracle_(std::move(corners)) {}

  // `in_contact`: the tick has a contact with the body.
  void Judge(const Vec3& tip, bool in_contact) {
    ++ticks;
    const int winding = oracle_.Winding(tip);
    const bool inside = winding != 0;
    crossed += winding != 0 && winding != 1;
    // A tip that went in and out on the other side is held by what it went through; so it has to have been inside.
    if (!in_contact) {
      entered_ = false;
    } else if (!entered_) {
      entered_ = inside || (ticks > 1 && PassesThrough(last_, tip));
    }
    const bool clear = !oracle_.IsNear(tip, kWithin_m);
    touching += in_contact;
    inside_ticks += inside && clear;
    CountRun(clear && inside && !in_contact, missed_run_, missed);
    CountRun(clear && !inside && in_contact && !entered_, false_run_, false_contacts);
    last_ = tip;
  }

  std::uint64_t ticks = 0, touching = 0, inside_ticks = 0, missed = 0, false_contacts = 0;
  std::uint64_t crossed = 0;  // the tip was where the body crosses itself

 private:
  bool PassesThrough(const Vec3& from, const Vec3& to) const {
    const int steps = static_cast<int>(Norm(to - from) / 1e-5);
    for (int k = 1; k < steps; ++k) {
      if (oracle_.IsInside(from + (static_cast<double>(k) / steps) * (to - from))) return true;
    }
    return false;
  }

  InsideOracle oracle_;
  Vec3 last_;
  bool entered_ = false;
  std::uint64_t missed_run_ = 0, false_run_ = 0;
};

}  // namespace omni::haptics
