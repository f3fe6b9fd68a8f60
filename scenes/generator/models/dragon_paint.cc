// Colours of the dragon: a plain function of place, normal and nearest shape.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "scenes/generator/models/dragon_shape.h"

namespace omni::scenes {
namespace {

double Step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

struct OnSpine {
  double t = 0;
  Vec away{0.0};  // from the spine, unit
  Vec along{1, 0, 0};
};

OnSpine NearestOnSpine(const Vec& p) {
  constexpr int kSteps = 180;
  OnSpine best;
  double least = std::numeric_limits<double>::max();
  for (int i = 0; i <= kSteps; ++i) {
    const SpinePoint at = SpineAt(static_cast<double>(i) / kSteps);
    const Vec d = p - at.position;
    if (glm::dot(d, d) >= least) continue;
    least = glm::dot(d, d);
    best.t = static_cast<double>(i) / kSteps;
    best.away = d / std::sqrt(std::max(least, 1e-9));
  }
  best.along = glm::normalize(SpineAt(best.t + 0.01).position - SpineAt(best.t - 0.01).position);
  return best;
}

double Hash(int x, int y, int z) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U +
                    static_cast<std::uint32_t>(z) * 2246822519U;
  h = (h ^ h >> 13) * 1274126177U;
  return static_cast<double>((h ^ h >> 16) & 0xFFFF) / 65535.0;
}

// Value noise in [0, 1].
double Mottle(const Vec& p) {
  const Vec cell(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  const Vec f = p - cell;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2 & 1;
    const double weight = (dx != 0 ? f.x : 1 - f.x) * (dy != 0 ? f.y : 1 - f.y) * (dz != 0 ? f.z : 1 - f.z);
    sum += weight * Hash(static_cast<int>(cell.x) + dx, static_cast<int>(cell.y) + dy, static_cast<int>(cell.z) + dz);
  }
  return sum;
}

// Green above, darker along the back, sandy plates below.
Vec SkinColour(const Vec& p, const Vec& normal) {
  const Vec back(0.018, 0.110, 0.085), flank(0.055, 0.270, 0.130), light(0.190, 0.400, 0.150),
      belly(0.720, 0.520, 0.240);
  const OnSpine spine = NearestOnSpine(p);
  const Vec reference = spine.t > 0.70 ? Vec(-0.75, 0, 0.66) : Vec(0, 0, 1);
  const Vec out = glm::normalize(reference - spine.along * glm::dot(reference, spine.along));
  const double height = glm::dot(spine.away, out);  // 1 on the back, -1 on the belly
  Vec colour = glm::mix(light, flank, Step(-0.6, 0.1, height));
  colour = glm::mix(colour, back, Step(0.25, 0.85, height));
  const double distance = glm::length(p - SpineAt(spine.t).position) / SpineAt(spine.t).radius;
  const double trunk = Step(1.45, 1.25, distance);
  const double under = trunk * Step(-0.50, -0.72, height) * Step(0.1, 0.25, spine.t);
  const double plate = spine.t * 46 - std::floor(spine.t * 46);
  const double plates = 0.80 + 0.20 * Step(0.0, 0.35, std::min(plate, 1 - plate) * 2);
  colour = glm::mix(colour * (0.84 + 0.30 * Mottle(p / 2.6)), belly * plates, under);
  return colour * (0.92 + 0.08 * normal.z);
}

Vec HeadColour(const Vec& p, const Vec& normal) {
  const Place head = HeadPlace();
  const Vec d = p - head.origin;
  const Vec local(glm::dot(d, head.forward), glm::dot(d, head.left), glm::dot(d, head.up));
  const double down = -glm::dot(normal, head.up);
  Vec colour = glm::mix(Vec(0.030, 0.160, 0.105), Vec(0.085, 0.320, 0.140), Step(-0.7, 0.4, down));
  if (local.z < -3.2) colour = glm::mix(colour, Vec(0.640, 0.460, 0.220), Step(0.0, 0.6, down));
  // Inside the jaws: facing the gap between them.
  const double gap = -2.7 - 0.18 * local.x;
  const bool between = local.x > 1.5 && local.x < 14 && std::abs(local.y) < 2.4;
  const double facing = local.z > gap ? down : -down;
  if (between && std::abs(local.z - gap) < 2.2)
    colour = glm::mix(colour, Vec(0.330, 0.030, 0.030), Step(0.35, 0.75, facing));
  return colour;
}

Vec EyeColour(const Vec& p) {
  const Place head = HeadPlace();
  const Vec d = p - head.origin;
  const Vec local(glm::dot(d, head.forward), std::abs(glm::dot(d, head.left)), glm::dot(d, head.up));
  const double across = local.x - 4.75, high = local.z - 1.45;  // a slit
  const double pupil = across * across / 0.10 + high * high / 0.9;
  return glm::mix(Vec(0.010, 0.008, 0.004), Vec(1.000, 0.520, 0.020), Step(0.7, 1.2, pupil));
}

Vec MembraneColour(const Vec& p) {
  const double outwards = Step(8, 52, std::abs(p.y));
  return glm::mix(Vec(0.400, 0.070, 0.035), Vec(0.780, 0.240, 0.050), outwards);
}

Vec PaintColour(std::uint32_t paint, const Vec& p, const Vec& normal) {
  const Place head = HeadPlace();
  const bool on_head = glm::dot(p - head.origin, head.forward) > -2.5 && glm::length(p - head.origin) < 20;
  switch (paint) {
    case kMembrane:
      return MembraneColour(p);
    case kBone:
      return glm::mix(Vec(0.040, 0.200, 0.110), Vec(0.240, 0.160, 0.070), Step(14, 50, std::abs(p.y)));
    case kHorn:
      return {0.760, 0.660, 0.430};
    case kRidge:
      return {0.460, 0.080, 0.035};
    case kEye:
      return EyeColour(p);
    case kMouth:
      return {0.420, 0.045, 0.050};
    default:
      return on_head ? HeadColour(p, normal) : SkinColour(p, normal);
  }
}

}  // namespace

Vec DragonColour(std::span<const Shape> shapes, const Vec& p, const Vec& normal) {
  double nearest[kPaintCount];
  std::fill(std::begin(nearest), std::end(nearest), 1e3);
  for (const Shape& shape : Near(shapes, p, 0.5)) {
    // The hole of a carved shape is lined with its paint.
    const double d = shape.carve ? std::abs(Distance(shape, p)) + 0.02 : Distance(shape, p);
    nearest[shape.paint] = std::min(nearest[shape.paint], d);
  }
  const double least = *std::min_element(std::begin(nearest), std::end(nearest));
  Vec sum(0.0);
  double weights = 0;
  for (std::uint32_t paint = 0; paint < kPaintCount; ++paint) {
    const double x = (nearest[paint] - least) / 0.16;
    const double weight = 1 / (1 + x * x * x * x);
    if (weight < 0.01) continue;
    sum += PaintColour(paint, p, normal) * weight;
    weights += weight;
  }
  return sum / weights;
}

double DragonImportance(const Vec& p) {
  const Place head = HeadPlace();
  if (glm::length(p - head(Vec(6, 0, 0))) < 13) return 30;
  if (glm::length(p) < kDome_mm + 3 && std::abs(p.y) > 9) return 6;     // feet
  if (std::abs(p.y) < 7 && p.x > -20 && glm::length(p) < 72) return 3;  // trunk: its markings
  return 1;
}

}  // namespace omni::scenes
