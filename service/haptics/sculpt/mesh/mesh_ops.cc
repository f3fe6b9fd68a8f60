#include "service/haptics/sculpt/mesh/mesh_ops.h"

#include "service/haptics/geometry/topology.h"

namespace omni::haptics::sculpt {
namespace {

void ReplaceNeighbour(PagedMesh& mesh, std::uint32_t t, std::uint32_t from, std::uint32_t to) {
  Triangle triangle = mesh.GetTriangle(t);
  for (std::uint32_t& other : triangle.neighbour) {
    if (other == from) other = to;
  }
  mesh.SetTriangle(t, triangle);
}

void SetCorners(PagedMesh& mesh, std::uint32_t t, std::array<std::uint32_t, 3> vertex,
                std::array<std::uint32_t, 3> neighbour) {
  Triangle triangle = mesh.GetTriangle(t);
  for (std::size_t k = 0; k < 3; ++k) {
    triangle.vertex[k] = vertex[k];
    triangle.neighbour[k] = neighbour[k];
  }
  mesh.SetTriangle(t, triangle);
}

bool Around(const Fan& fan, std::uint32_t vertex) noexcept {
  for (int i = 0; i < fan.size(); ++i) {
    if (fan.next(i) == vertex) return true;
  }
  return false;
}

}  // namespace

Diamond DiamondOf(const PagedMesh& mesh, const Edge& edge) noexcept {
  const Triangle& t = mesh.GetTriangle(edge.triangle);
  const std::uint32_t k1 = (edge.k + 1) % 3, k2 = (edge.k + 2) % 3;
  Diamond d{};
  d.t = edge.triangle;
  d.o = t.neighbour[edge.k];
  d.a = t.vertex[edge.k];
  d.b = t.vertex[k1];
  d.c = t.vertex[k2];
  d.t_bc = t.neighbour[k1];
  d.t_ca = t.neighbour[k2];
  const Triangle& o = mesh.GetTriangle(d.o);
  const auto at_b = static_cast<std::uint32_t>(CornerOf(o, d.b));
  d.d = o.vertex[(at_b + 2) % 3];
  d.o_ad = o.neighbour[(at_b + 1) % 3];
  d.o_db = o.neighbour[(at_b + 2) % 3];
  return d;
}

Fan::Fan(const PagedMesh& mesh, std::uint32_t vertex) noexcept {
  const std::uint32_t start = mesh.FirstTriangle(vertex);
  std::uint32_t current = start;
  do {
    if (size_ == kMaxValence) {
      size_ = 0;
      return;
    }
    const Triangle& t = mesh.GetTriangle(current);
    const auto corner = static_cast<std::size_t>(CornerOf(t, vertex));
    triangle_[static_cast<std::size_t>(size_)] = current;
    next_[static_cast<std::size_t>(size_++)] = t.vertex[(corner + 1) % 3];
    current = t.neighbour[corner];
  } while (current != start);
}

std::uint32_t DescendTo(const PagedMesh& mesh, std::uint32_t triangle, const Vec3& p) noexcept {
  double least = ClosestOnTriangle(mesh.TriangleCorners(triangle), p).distance_squared;
  for (bool again = true; again;) {
    again = false;
    const Triangle from = mesh.GetTriangle(triangle);
    for (const std::uint32_t v : from.vertex) {
      const Fan fan(mesh, v);
      for (int i = 0; i < fan.size(); ++i) {
        const double distance = ClosestOnTriangle(mesh.TriangleCorners(fan.triangle(i)), p).distance_squared;
        if (!(distance < least)) continue;
        least = distance;
        triangle = fan.triangle(i);
        again = true;
      }
    }
  }
  return triangle;
}

// (a, b, c), (b, a, d) -> (a, m, c), (m, b, c), (m, a, d), (b, m, d)
std::uint32_t SplitEdge(PagedMesh& mesh, const Edge& edge, const Vec3& position) {
  if (!mesh.HasRoom()) return kNoIndex;
  const Diamond e = DiamondOf(mesh, edge);
  const std::uint32_t m = mesh.AddVertex(e.a, position);
  const std::uint32_t t2 = mesh.AddTriangle(e.t, mesh.GetTriangle(e.t));
  const std::uint32_t o2 = mesh.AddTriangle(e.o, mesh.GetTriangle(e.o));
  SetCorners(mesh, e.t, {e.a, m, e.c}, {e.o, t2, e.t_ca});
  SetCorners(mesh, t2, {m, e.b, e.c}, {o2, e.t_bc, e.t});
  SetCorners(mesh, e.o, {m, e.a, e.d}, {e.t, e.o_ad, o2});
  SetCorners(mesh, o2, {e.b, m, e.d}, {t2, e.o, e.o_db});
  ReplaceNeighbour(mesh, e.t_bc, e.t, t2);
  ReplaceNeighbour(mesh, e.o_db, e.o, o2);
  mesh.SetFirstTriangle(m, e.t);
  mesh.SetFirstTriangle(e.b, t2);
  return m;
}

bool CanCollapse(const Diamond& e, const PagedMesh& mesh, const Fan& fan_a, const Fan& fan_b) noexcept {
  if (fan_a.size() < 3 || fan_b.size() < 3 || fan_a.size() + fan_b.size() - 4 > kMaxValence) return false;
  int common = 0;
  for (int i = 0; i < fan_a.size(); ++i) common += Around(fan_b, fan_a.next(i)) ? 1 : 0;
  return common == 2 && Fan(mesh, e.c).size() > 3 && Fan(mesh, e.d).size() > 3;
}

void CollapseEdge(PagedMesh& mesh, const Diamond& e, const Fan& fan_a) {
  for (int i = 0; i < fan_a.size(); ++i) {
    Triangle triangle = mesh.GetTriangle(fan_a.triangle(i));
    triangle.vertex[CornerOf(triangle, e.a)] = e.b;
    mesh.SetTriangle(fan_a.triangle(i), triangle);
  }
  ReplaceNeighbour(mesh, e.t_bc, e.t, e.t_ca);
  ReplaceNeighbour(mesh, e.t_ca, e.t, e.t_bc);
  ReplaceNeighbour(mesh, e.o_ad, e.o, e.o_db);
  ReplaceNeighbour(mesh, e.o_db, e.o, e.o_ad);
  mesh.SetFirstTriangle(e.b, e.t_ca);
  mesh.SetFirstTriangle(e.c, e.t_ca);
  mesh.SetFirstTriangle(e.d, e.o_ad);
  mesh.RemoveTriangle(e.t);
  mesh.RemoveTriangle(e.o);
  mesh.RemoveVertex(e.a);
}

bool CanFlip(const PagedMesh& mesh, const Diamond& e, const Fan& fan_c, int valence_a, int valence_b) noexcept {
  return e.c != e.d && valence_a > 3 && valence_b > 3 && fan_c.size() >= 3 && !Around(fan_c, e.d) &&
         mesh.GetTriangle(e.t).material == mesh.GetTriangle(e.o).material;
}

// (a, b, c), (b, a, d) -> (d, b, c), (c, a, d)
void FlipEdge(PagedMesh& mesh, const Diamond& e) {
  SetCorners(mesh, e.t, {e.d, e.b, e.c}, {e.o_db, e.t_bc, e.o});
  SetCorners(mesh, e.o, {e.c, e.a, e.d}, {e.t_ca, e.o_ad, e.t});
  ReplaceNeighbour(mesh, e.o_db, e.o, e.t);
  ReplaceNeighbour(mesh, e.t_ca, e.t, e.o);
  mesh.SetFirstTriangle(e.a, e.o);
  mesh.SetFirstTriangle(e.b, e.t);
  mesh.SetFirstTriangle(e.c, e.t);
  mesh.SetFirstTriangle(e.d, e.t);
}

}  // namespace omni::haptics::sculpt
