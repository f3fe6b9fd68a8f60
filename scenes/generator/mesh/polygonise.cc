#include "scenes/generator/mesh/polygonise.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <unordered_map>

namespace omni::scenes {
namespace {

constexpr int kBlock = 8;  // cells along a block's edge

// Six tetrahedra around the diagonal 0-7 of a cell; corner bits: 1 = x, 2 = y, 4 = z. Neighbouring cells split their
// common face along the same diagonal, so the surface has no cracks   [Kuhn's triangulation]
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

class Marcher {
 public:
  Marcher(std::span<const Shape> shapes, const Vec& lower, const Vec& upper, double cell)
      : shapes_(shapes), lower_(lower), cell_(cell) {
    for (int k = 0; k < 3; ++k) {
      blocks_[k] = static_cast<int>(std::ceil((upper[k] - lower[k]) / (cell * kBlock)));
      points_[k] = blocks_[k] * kBlock + 1;
    }
    values_.assign(static_cast<std::size_t>(points_[0]) * static_cast<std::size_t>(points_[1]) *
                       static_cast<std::size_t>(points_[2]),
                   0);
    known_.assign(values_.size(), false);
  }

  Mesh Run() {
    for (int z = 0; z < blocks_[2]; ++z) {
      for (int y = 0; y < blocks_[1]; ++y) {
        for (int x = 0; x < blocks_[0]; ++x) Block(x * kBlock, y * kBlock, z * kBlock);
      }
    }
    return std::move(mesh_);
  }

 private:
  Vec PointAt(int x, int y, int z) const { return lower_ + Vec(x, y, z) * cell_; }
  std::size_t IndexOf(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(points_[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(points_[0]) +
           static_cast<std::size_t>(x);
  }

  void Block(int x0, int y0, int z0) {
    const Vec centre = lower_ + (Vec(x0, y0, z0) + 0.5 * kBlock) * cell_;
    const double reach = 0.5 * kBlock * cell_ * std::sqrt(3.0);
    const std::vector<Shape> near = Near(shapes_, centre, reach);
    if (near.empty() || std::abs(Field(near, centre)) > reach) return;  // the field's slope is at most 1
    for (int z = z0; z <= z0 + kBlock; ++z) {
      for (int y = y0; y <= y0 + kBlock; ++y) {
        for (int x = x0; x <= x0 + kBlock; ++x) Evaluate(near, x, y, z);
      }
    }
    for (int z = z0; z < z0 + kBlock; ++z) {
      for (int y = y0; y < y0 + kBlock; ++y) {
        for (int x = x0; x < x0 + kBlock; ++x) Cell(near, x, y, z);
      }
    }
  }

  void Evaluate(const std::vector<Shape>& near, int x, int y, int z) {
    const std::size_t i = IndexOf(x, y, z);
    if (known_[i]) return;
    known_[i] = true;
    const double d = Field(near, PointAt(x, y, z));
    values_[i] = d == 0 ? 1e-12 : d;
  }

  void Cell(const std::vector<Shape>& near, int x, int y, int z) {
    int inside = 0;
    for (int corner = 0; corner < 8; ++corner) inside |= (Value(x, y, z, corner) < 0 ? 1 : 0) << corner;
    if (inside == 0 || inside == 255) return;
    for (const auto& tetrahedron : kTetrahedra) Tetrahedron(near, x, y, z, tetrahedron);
  }

  double Value(int x, int y, int z, int corner) const {
    return values_[IndexOf(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1))];
  }

  void Tetrahedron(const std::vector<Shape>& near, int x, int y, int z, const int (&corners)[4]) {
    int in[4], out[4], in_count = 0, out_count = 0;
    for (const int corner : corners) {
      if (Value(x, y, z, corner) < 0) {
        in[in_count++] = corner;
      } else {
        out[out_count++] = corner;
      }
    }
    const auto cut = [&](int a, int b) { return Vertex(near, x, y, z, a, b); };
    const Vec outward = Centre(out, out_count) - Centre(in, in_count);
    if (in_count == 1) Emit(cut(in[0], out[0]), cut(in[0], out[1]), cut(in[0], out[2]), outward);
    if (in_count == 3) Emit(cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0]), outward);
    if (in_count == 2) {
      const std::uint32_t a = cut(in[0], out[0]), b = cut(in[0], out[1]), c = cut(in[1], out[1]),
                          d = cut(in[1], out[0]);
      Emit(a, b, c, outward);
      Emit(a, c, d, outward);
    }
  }

  static Vec Centre(const int* corners, int count) {
    Vec sum(0.0);
    for (int i = 0; i < count; ++i) sum += Vec(corners[i] & 1, corners[i] >> 1 & 1, corners[i] >> 2 & 1);
    return count > 0 ? sum / static_cast<double>(count) : sum;
  }

  // Orientation from the unmoved cuts: they cannot fold.
  void Emit(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Vec& outward) {
    const Vec normal = glm::cross(cuts_[b] - cuts_[a], cuts_[c] - cuts_[a]);
    if (glm::dot(normal, outward) >= 0) {
      mesh_.triangles.push_back({a, b, c});
    } else {
      mesh_.triangles.push_back({a, c, b});
    }
  }

  std::uint32_t Vertex(const std::vector<Shape>& near, int x, int y, int z, int a, int b) {
    const int low = std::min(a, b), high = std::max(a, b);
    const std::size_t base = IndexOf(x + (low & 1), y + (low >> 1 & 1), z + (low >> 2 & 1));
    const std::uint64_t key = static_cast<std::uint64_t>(base) * 8 + static_cast<std::uint64_t>(high ^ low);
    const auto [found, is_new] = vertices_.emplace(key, static_cast<std::uint32_t>(cuts_.size()));
    if (is_new) {
      const double va = Value(x, y, z, low), vb = Value(x, y, z, high);
      // Not nearer than 2 % to a grid point: no two cuts coincide.
      const double t = std::clamp(va / (va - vb), 0.02, 0.98);
      const Vec pa = PointAt(x + (low & 1), y + (low >> 1 & 1), z + (low >> 2 & 1));
      const Vec pb = PointAt(x + (high & 1), y + (high >> 1 & 1), z + (high >> 2 & 1));
      cuts_.push_back(pa + (pb - pa) * t);
      mesh_.positions.push_back(OntoSurface(near, cuts_.back()));
    }
    return found->second;
  }

  // p <- p - f g / |g|^2, at most a third of a cell from the cut.
  Vec OntoSurface(const std::vector<Shape>& near, const Vec& cut) const {
    Vec p = cut;
    for (int i = 0; i < 2; ++i) {
      const Vec g = FieldGradient(near, p);
      const double square = glm::dot(g, g);
      if (!(square > 0.05)) break;  // a crease: the gradient says nothing
      p -= g * (Field(near, p) / square);
    }
    const double moved = glm::length(p - cut);
    const double most = cell_ / 3;
    return moved > most ? cut + (p - cut) * (most / moved) : p;
  }

  std::span<const Shape> shapes_;
  Vec lower_;
  double cell_;
  int blocks_[3] = {}, points_[3] = {};
  std::vector<double> values_;
  std::vector<bool> known_;
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;
  std::vector<Vec> cuts_;
  Mesh mesh_;
};

}  // namespace

Mesh Polygonise(std::span<const Shape> shapes, const Vec& lower, const Vec& upper, double cell) {
  return Marcher(shapes, lower, upper, cell).Run();
}

}  // namespace omni::scenes
