// Wings: an arm of two bones, four fingers, membranes between them that sag and end in scallops.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "scenes/generator/models/dragon_shape.h"

namespace omni::scenes {
namespace {

constexpr double kMembrane_mm = 0.45;  // half its thickness

// The left wing. Spread, raised and swept back, so that the trunk stays free for the pen from above.
const Vec kShoulder(7.0, 5.0, 43.5), kElbow(-4.0, 18.6, 54.5), kWrist(5.5, 31.0, 65.5), kHip(-15.0, 4.6, 40.5);
const std::array<Vec, 4> kFingerTip = {Vec(-7.0, 56.0, 76.5), Vec(-23.0, 50.0, 67.0), Vec(-32.0, 38.0, 57.0),
                                       Vec(-31.0, 24.0, 48.5)};
const std::array<double, 4> kArch = {3.6, 4.2, 3.6, 2.6};  // how far a finger bows upwards

Vec Finger(std::size_t i, double v) {
  const Vec up = glm::normalize(Vec(0.1, -0.35, 0.9));
  return kWrist + (kFingerTip[i] - kWrist) * v + up * (kArch[i] * 4 * v * (1 - v));
}

// The membrane's inner border: wrist -> elbow -> flank.
Vec Inner(double v) {
  constexpr double kElbowAt = 0.42;
  return v < kElbowAt ? kWrist + (kElbow - kWrist) * (v / kElbowAt)
                      : kElbow + (kHip - kElbow) * ((v - kElbowAt) / (1 - kElbowAt));
}

// Parabola through 0, 1, 0.
double Bow(double u) { return 4 * u * (1 - u); }

class Wing {
 public:
  Wing(std::vector<Shape>& shapes, double side) : shapes_(shapes), side_(side) {}

  void Add() {
    Membranes();
    Bone(kShoulder, 3.0, kElbow, 2.1, 1.8);
    Bone(kElbow, 2.1, kWrist, 1.7, 0.8);
    for (std::size_t i = 0; i < kFingerTip.size(); ++i) {
      constexpr int kSegments = 6;
      for (int k = 0; k < kSegments; ++k) {
        const double v0 = static_cast<double>(k) / kSegments, v1 = static_cast<double>(k + 1) / kSegments;
        Bone(Finger(i, v0), 1.25 - 0.65 * v0, Finger(i, v1), 1.25 - 0.65 * v1, 0.4);
      }
      const Vec beyond = Finger(i, 1) + glm::normalize(Finger(i, 1) - Finger(i, 0.8)) * 2.0;
      shapes_.push_back(RoundCone(Flip(Finger(i, 1)), 0.6, Flip(beyond), 0.25, 0.2, kHorn));
    }
    shapes_.push_back(RoundCone(Flip(kWrist), 1.2, Flip(kWrist + Vec(3.0, 0.6, 4.4)), 0.3, 0.5, kHorn));
    shapes_.push_back(RoundCone(Flip(kElbow), 1.3, Flip(kElbow + Vec(-3.2, 0.8, 2.0)), 0.3, 0.5, kHorn));
  }

 private:
  Vec Flip(const Vec& p) const { return {p.x, side_ * p.y, p.z}; }

  void Bone(const Vec& a, double radius_a, const Vec& b, double radius_b, double blend) {
    shapes_.push_back(RoundCone(Flip(a), radius_a, Flip(b), radius_b, blend, kBone));
  }

  void Membranes() {
    for (std::size_t i = 0; i + 1 < kFingerTip.size(); ++i) {
      Patch([i](double v) { return Finger(i, v); }, [i](double v) { return Finger(i + 1, v); }, 0.20, 1.6);
    }
    Patch([](double v) { return Finger(3, v); }, [](double v) { return Inner(v); }, 0.16, 1.2);
    // Between trunk, elbow and shoulder, and the fold in front of the elbow.
    Sheet(kShoulder, kElbow, kHip);
    Sheet(kShoulder + Vec(2.0, 1.5, 1.0), kElbow, (kShoulder + kWrist) * 0.5 + Vec(-0.8, 1.0, -2.2));
    Sheet(kElbow, kWrist, (kShoulder + kWrist) * 0.5 + Vec(-0.8, 1.0, -2.2));
  }

  // Ruled surface between two borders that start at the wrist; its far edge is cut back by `scallop` half-way, and it
  // hangs by `sag` mm.
  template <class A, class B>
  void Patch(A border_a, B border_b, double scallop, double sag) {
    constexpr int kAcross = 6, kAlong = 5;
    const auto at = [&](int i, int k) {
      const double u = static_cast<double>(i) / kAcross;
      const double v = (1 - scallop * Bow(u)) * static_cast<double>(k) / kAlong;
      return border_a(v) * (1 - u) + border_b(v) * u - Vec(0, 0, sag * Bow(u) * v);
    };
    for (int i = 0; i < kAcross; ++i) {
      for (int k = 0; k < kAlong; ++k) {
        if (k > 0) Sheet(at(i, k), at(i + 1, k + 1), at(i + 1, k));
        Sheet(at(i, k), at(i, k + 1), at(i + 1, k + 1));
      }
    }
  }

  void Sheet(const Vec& a, const Vec& b, const Vec& c) {
    shapes_.push_back(Slab(Flip(a), Flip(b), Flip(c), kMembrane_mm, 0.3, kMembrane));
  }

  std::vector<Shape>& shapes_;
  double side_;
};

}  // namespace

void AddWings(std::vector<Shape>& shapes) {
  for (const double side : {-1.0, 1.0}) Wing(shapes, side).Add();
}

}  // namespace omni::scenes
