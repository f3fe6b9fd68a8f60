#include "scenes/generator/pictures/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <span>
#include <stdexcept>
#include <utility>

#include "service/base/in_parallel.h"
#include "service/scene/drawn_scene.h"

namespace omni::scenes {
namespace {

std::vector<Vec> Points(const std::vector<base::Vec3>& from) {
  std::vector<Vec> points;
  points.reserve(from.size());
  for (const base::Vec3& p : from) points.emplace_back(p.x, p.y, p.z);
  return points;
}

double Extent_m(const std::vector<DrawnMesh>& meshes) {
  Vec lower(1e9), upper(-1e9);
  for (const DrawnMesh& drawn : meshes) {
    for (const Vec& p : drawn.mesh.positions) {
      lower = glm::min(lower, p);
      upper = glm::max(upper, p);
    }
  }
  return glm::length(upper - lower);
}

}  // namespace

std::vector<DrawnMesh> ReadMeshes(const std::string& path) {
  const base::Result<scene::DrawnScene> scene = scene::LoadDrawnScene(path);
  if (!scene.ok()) throw std::runtime_error(scene.error());
  for (const std::string& note : scene->notes) std::fprintf(stderr, "scene_render: %s\n", note.c_str());
  std::vector<DrawnMesh> meshes;
  for (const scene::DrawnPart& part : scene->parts) {
    DrawnMesh drawn{.name = part.name, .mesh = {}, .normals = Points(part.normals_base), .roughness = part.roughness};
    drawn.mesh.positions = Points(part.positions_base_m);
    drawn.mesh.colours = Points(part.colours);
    drawn.mesh.triangles = part.triangles;
    meshes.push_back(std::move(drawn));
  }
  if (!(Extent_m(meshes) > 0)) throw std::runtime_error(path + ": all vertices lie in one point; check the export");
  return meshes;
}

namespace {

constexpr int kSkyDirections = 160;
constexpr int kShadowSize = 640;
constexpr std::size_t kLightsAtOnce = 8;
constexpr double kGoldenAngle = 2.399963229728653;

// Orthographic camera: right, up, and towards the eye.
struct Camera {
  Vec right, up, eye;
  Vec centre;
  double scale = 1;  // pixels per metre
  int width = 1, height = 1;

  static Camera Looking(const Vec& towards_eye) {
    Camera camera;
    camera.eye = glm::normalize(towards_eye);
    const Vec reference = std::abs(camera.eye.z) > 0.99 ? Vec(0, 1, 0) : Vec(0, 0, 1);
    camera.right = glm::normalize(glm::cross(reference, camera.eye));
    camera.up = glm::cross(camera.eye, camera.right);
    return camera;
  }
  // Pixel x, y (from the top) and depth (greater = nearer).
  Vec Project(const Vec& p) const {
    const Vec d = p - centre;
    return {width / 2.0 + glm::dot(d, right) * scale, height / 2.0 - glm::dot(d, up) * scale, glm::dot(d, eye)};
  }
};

// Distant, with its shadow map.
struct Light {
  Vec direction, radiance;
  bool gloss = false;
  Camera sun{};
  std::vector<float> depth{};
};

struct Fragment {
  float depth = -1e9F;
  std::int32_t mesh = -1;
  std::uint32_t triangle = 0;
  float u = 0, v = 0;
};

// Calls visit(pixel index, depth, u, v) for each pixel centre inside the triangle.
template <class Visit>
void Rasterise(const Vec (&p)[3], int width, int height, Visit visit) {
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
  if (!(std::abs(area) > 1e-12)) return;
  // Clamped before they become whole numbers: corners may lie far outside.
  const auto low = [&](double a, double b, double c, int size) {
    return static_cast<int>(std::clamp(std::floor(std::min({a, b, c})), 0.0, static_cast<double>(size)));
  };
  const auto high = [&](double a, double b, double c, int size) {
    return static_cast<int>(std::clamp(std::max({a, b, c}), -1.0, size - 1.0));
  };
  const int x0 = low(p[0].x, p[1].x, p[2].x, width), y0 = low(p[0].y, p[1].y, p[2].y, height);
  const int x1 = high(p[0].x, p[1].x, p[2].x, width), y1 = high(p[0].y, p[1].y, p[2].y, height);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double px = x + 0.5 - p[0].x, py = y + 0.5 - p[0].y;
      const double u = (px * (p[2].y - p[0].y) - py * (p[2].x - p[0].x)) / area;
      const double v = (py * (p[1].x - p[0].x) - px * (p[1].y - p[0].y)) / area;
      if (u < 0 || v < 0 || u + v > 1) continue;
      const double depth = p[0].z * (1 - u - v) + p[1].z * u + p[2].z * v;
      visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x), depth, u, v);
    }
  }
}

class Painter {
 public:
  Painter(const std::vector<DrawnMesh>& meshes, const PictureOptions& options) : meshes_(meshes), options_(options) {
    Vec lower(1e9), upper(-1e9);
    for (const DrawnMesh& mesh : meshes_) {
      for (const Vec& p : mesh.mesh.positions) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
      }
    }
    centre_ = (lower + upper) * 0.5;
    floor_ = lower.z - 1e-4;
    radius_ = glm::length(upper - lower) / 2;
    const double a = options.view.azimuth_deg * std::numbers::pi / 180,
                 e = options.view.elevation_deg * std::numbers::pi / 180;
    camera_ = Camera::Looking({std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)});
    camera_.width = options.width * options.supersampling;
    camera_.height = options.height * options.supersampling;
    FitCamera();
  }

  std::vector<std::uint8_t> Run() {
    DrawFragments();
    surfaces_.reserve(fragments_.size());
    for (std::size_t i = 0; i < fragments_.size(); ++i) surfaces_.push_back(At(i));
    light_.assign(fragments_.size(), Vec(0.0));
    Shine(Lights());
    return Resolve();
  }

 private:
  void FitCamera() {
    if (options_.look_at_m) {
      camera_.centre = *options_.look_at_m;
      camera_.scale = options_.zoom * std::min(camera_.width, camera_.height) / options_.span_m;
      return;
    }
    double left = 1e9, right = -1e9, low = 1e9, high = -1e9;
    for (const DrawnMesh& mesh : meshes_) {
      for (const Vec& p : mesh.mesh.positions) {
        const double x = glm::dot(p, camera_.right), y = glm::dot(p, camera_.up);
        left = std::min(left, x);
        right = std::max(right, x);
        low = std::min(low, y);
        high = std::max(high, y);
      }
    }
    camera_.centre = camera_.right * ((left + right) / 2) + camera_.up * ((low + high) / 2) +
                     camera_.eye * glm::dot(centre_, camera_.eye);
    const double least = 1e-3 * radius_;  // of what is seen as a point from here
    camera_.scale =
        options_.zoom * 0.88 *
        std::min(camera_.width / std::max(right - left, least), camera_.height / std::max(high - low, least));
  }

  void DrawFragments() {
    fragments_.assign(static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height), {});
    for (std::size_t m = 0; m < meshes_.size(); ++m) {
      const Mesh& mesh = meshes_[m].mesh;
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        Vec p[3];
        for (std::size_t k = 0; k < 3; ++k) p[k] = camera_.Project(mesh.positions[mesh.triangles[t][k]]);
        const double nearer = meshes_[m].overlay ? 4 * radius_ : 0;
        for (Vec& corner : p) corner.z += nearer;
        Rasterise(p, camera_.width, camera_.height, [&](std::size_t i, double depth, double u, double v) {
          if (static_cast<float>(depth) <= fragments_[i].depth) return;
          fragments_[i] = {static_cast<float>(depth), static_cast<std::int32_t>(m), t, static_cast<float>(u),
                           static_cast<float>(v)};
        });
      }
    }
  }

  struct Surface {
    bool hit = false;
    Vec p{0.0}, n{0, 0, 1}, colour{0.0};
    double roughness = 1;
    bool floor = false, overlay = false;
  };

  Surface At(std::size_t i) const {
    Surface s;
    const Fragment& f = fragments_[i];
    if (f.mesh >= 0) {
      const DrawnMesh& drawn = meshes_[static_cast<std::size_t>(f.mesh)];
      const Triangle& t = drawn.mesh.triangles[f.triangle];
      const double u = f.u, v = f.v, w = 1 - u - v;
      s.hit = true;
      s.p = drawn.mesh.positions[t[0]] * w + drawn.mesh.positions[t[1]] * u + drawn.mesh.positions[t[2]] * v;
      s.n = glm::normalize(drawn.normals[t[0]] * w + drawn.normals[t[1]] * u + drawn.normals[t[2]] * v + Vec(1e-9));
      s.colour = drawn.mesh.colours[t[0]] * w + drawn.mesh.colours[t[1]] * u + drawn.mesh.colours[t[2]] * v;
      s.roughness = drawn.roughness;
      s.overlay = drawn.overlay;
      return s;
    }
    if (camera_.eye.z < 0.02) return s;
    // The floor under the pixel.
    const auto width = static_cast<std::size_t>(camera_.width);
    const std::size_t column = i % width, row = i / width;
    const double x = (static_cast<double>(column) + 0.5 - camera_.width / 2.0) / camera_.scale;
    const double y = (camera_.height / 2.0 - static_cast<double>(row) - 0.5) / camera_.scale;
    const Vec on_plane = camera_.centre + camera_.right * x + camera_.up * y;
    s.p = on_plane + camera_.eye * ((floor_ - on_plane.z) / camera_.eye.z);
    const double away = glm::length(glm::dvec2(s.p.x - centre_.x, s.p.y - centre_.y));
    s.hit = s.floor = away < 2.2 * radius_;
    return s;
  }

  // Directions over the upper hemisphere (Fibonacci spiral), the sky bluish, one side warm and bright: the key light.
  std::vector<Light> Lights() const {
    std::vector<Light> lights;
    Vec sum(0.0);
    for (int k = 0; k < kSkyDirections; ++k) {
      const double z = 0.03 + 0.97 * (k + 0.5) / kSkyDirections, r = std::sqrt(1 - z * z);
      const Vec direction(r * std::cos(k * kGoldenAngle), r * std::sin(k * kGoldenAngle), z);
      const Vec sky = Vec(0.80, 0.90, 1.10) * (0.55 + 0.45 * z);
      sum += sky * z;
      lights.push_back({direction, sky, false});
    }
    // Scaled so that an open horizontal surface gets about 0.75 from the sky; the key and its penumbra come on top.
    for (Light& light : lights) light.radiance *= 0.62 / sum.y;
    constexpr int kKeyRays = 24;
    const Vec key = glm::normalize(camera_.right * -0.55 + camera_.eye * 0.50 + Vec(0, 0, 0.85));
    const Camera aim = Camera::Looking(key);
    for (int k = 0; k < kKeyRays; ++k) {
      const double r = 0.09 * std::sqrt((k + 0.5) / kKeyRays);
      const Vec direction = glm::normalize(key + aim.right * (r * std::cos(k * kGoldenAngle)) +
                                           aim.up * (r * std::sin(k * kGoldenAngle)));
      lights.push_back({direction, Vec(1.22, 1.08, 0.88) / static_cast<double>(kKeyRays), true});
    }
    const Vec rim = glm::normalize(camera_.right * 0.7 - camera_.eye * 0.75 + Vec(0, 0, 0.55));
    lights.push_back({rim, Vec(0.34, 0.42, 0.55), false});
    return lights;
  }

  // A few lights at a time, since all surfaces pass through the processor's caches for each few.
  void Shine(std::vector<Light> lights) {
    for (std::size_t first = 0; first < lights.size(); first += kLightsAtOnce) {
      const std::span<Light> some = std::span(lights).subspan(first, std::min(kLightsAtOnce, lights.size() - first));
      base::InParallel(some.size(), [&](std::size_t k) { DrawShadow(some[k]); });
      base::InParallel(static_cast<std::size_t>(camera_.height), [&](std::size_t row) {
        const auto width = static_cast<std::size_t>(camera_.width);
        for (std::size_t i = row * width; i < (row + 1) * width; ++i) {
          if (!surfaces_[i].hit) continue;
          for (const Light& light : some) Add(light, surfaces_[i], light_[i]);
        }
      });
      for (Light& light : some) light.depth = {};
    }
  }

  void DrawShadow(Light& light) const {
    light.sun = Camera::Looking(light.direction);
    light.sun.width = light.sun.height = kShadowSize;
    light.sun.centre = centre_;
    light.sun.scale = kShadowSize / (2.1 * radius_);
    light.depth.assign(std::size_t{kShadowSize} * kShadowSize, -1e9F);
    for (const DrawnMesh& drawn : meshes_) {
      if (drawn.overlay) continue;
      for (const Triangle& t : drawn.mesh.triangles) {
        Vec p[3];
        for (std::size_t k = 0; k < 3; ++k) p[k] = light.sun.Project(drawn.mesh.positions[t[k]]);
        Rasterise(p, kShadowSize, kShadowSize, [&](std::size_t i, double d, double, double) {
          light.depth[i] = std::max(light.depth[i], static_cast<float>(d));
        });
      }
    }
  }

  void Add(const Light& light, const Surface& s, Vec& sum) const {
    const double cosine = glm::dot(s.n, light.direction);
    if (!(cosine > 0)) return;
    // Looked up a little off the surface, so that it does not shade itself.
    const Vec q = light.sun.Project(s.p + s.n * (0.012 * radius_));
    const int x = static_cast<int>(q.x), y = static_cast<int>(q.y);
    if (!s.overlay && x >= 0 && y >= 0 && x < kShadowSize && y < kShadowSize &&
        light.depth[static_cast<std::size_t>(y) * kShadowSize + static_cast<std::size_t>(x)] > q.z) {
      return;
    }
    sum += light.radiance * cosine;
    if (!light.gloss || s.floor) return;
    const double power = 12 + 70 * (1 - s.roughness);
    const Vec half = glm::normalize(light.direction + camera_.eye);
    const double shine = std::pow(std::max(glm::dot(s.n, half), 0.0), power) * (1 - s.roughness) * 0.8;
    // Divided by the colour below, so that highlights stay white.
    sum += light.radiance * shine / glm::max(s.colour, Vec(0.04));
  }

  Vec Background(std::size_t i) const {
    const std::size_t row = i / static_cast<std::size_t>(camera_.width);
    const double y = static_cast<double>(row) / camera_.height;
    return glm::mix(Vec(0.42, 0.50, 0.60), Vec(0.66, 0.67, 0.66), y);
  }

  Vec Shade(std::size_t i) const {
    const Surface& s = surfaces_[i];
    const Vec background = Background(i);
    if (!s.hit) return background;
    if (s.floor) {
      // The floor is the background, darkened where light is missing, and fades into it.
      const double away = glm::length(glm::dvec2(s.p.x - centre_.x, s.p.y - centre_.y)) / (2.2 * radius_);
      const double open = 1.55;
      const double lit = std::clamp(light_[i].y / open, 0.0, 1.0);
      const double fade = std::clamp((1 - away) * 2.5, 0.0, 1.0);
      return background * (1 - fade * 0.75 * (1 - lit));
    }
    return s.colour * (light_[i] + Vec(0.10, 0.095, 0.09)) * 0.80;
  }

  std::vector<std::uint8_t> Resolve() const {
    const int n = options_.supersampling;
    std::vector<std::uint8_t> pixels;
    for (int y = 0; y < options_.height; ++y) {
      for (int x = 0; x < options_.width; ++x) {
        Vec sum(0.0);
        for (int k = 0; k < n * n; ++k) {
          const Vec c = Shade(static_cast<std::size_t>(y * n + k / n) * static_cast<std::size_t>(camera_.width) +
                              static_cast<std::size_t>(x * n + k % n));
          // Tone mapping per sample keeps bright edges smooth   [Narkowicz' fit of ACES]
          sum += glm::clamp(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14), Vec(0.0), Vec(1.0));
        }
        sum /= static_cast<double>(n * n);
        for (const double c : {sum.x, sum.y, sum.z}) {
          const double srgb = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
          pixels.push_back(static_cast<std::uint8_t>(std::clamp(srgb * 255 + 0.5, 0.0, 255.0)));
        }
      }
    }
    return pixels;
  }

  const std::vector<DrawnMesh>& meshes_;
  PictureOptions options_;
  Camera camera_;
  Vec centre_{0.0};
  double floor_ = 0, radius_ = 1;
  std::vector<Fragment> fragments_;
  std::vector<Surface> surfaces_;
  std::vector<Vec> light_;
};

}  // namespace

std::vector<std::uint8_t> Render(const std::vector<DrawnMesh>& meshes, const PictureOptions& options) {
  return Painter(meshes, options).Run();
}

}  // namespace omni::scenes
