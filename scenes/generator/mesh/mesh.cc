#include "scenes/generator/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>

namespace omni::scenes {

double Quantised(double value_m) { return std::nearbyint(value_m * 2097152.0) / 2097152.0 + 0.0; }

void Weld(Mesh& mesh) {
  std::map<std::array<double, 3>, std::uint32_t> numbers;
  std::vector<std::uint32_t> number(mesh.positions.size());
  Mesh welded;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec& p = mesh.positions[i];
    const std::array<double, 3> key{Quantised(p.x), Quantised(p.y), Quantised(p.z)};
    const auto [found, is_new] = numbers.emplace(key, static_cast<std::uint32_t>(welded.positions.size()));
    if (is_new) {
      welded.positions.emplace_back(key[0], key[1], key[2]);
      if (!mesh.colours.empty()) welded.colours.push_back(mesh.colours[i]);
    }
    number[i] = found->second;
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.triangles[i];
    const Triangle t{number[a], number[b], number[c]};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    welded.triangles.push_back(t);
    if (!mesh.groups.empty()) welded.groups.push_back(mesh.groups[i]);
  }
  mesh = std::move(welded);
}

void Append(Mesh& mesh, const Mesh& part, std::uint32_t group) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.groups.resize(mesh.triangles.size(), 0);
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  mesh.colours.insert(mesh.colours.end(), part.colours.begin(), part.colours.end());
  for (const auto& [a, b, c] : part.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  mesh.groups.resize(mesh.triangles.size(), group);
}

std::vector<Vec> VertexNormals(const Mesh& mesh) {
  std::vector<Vec> normals(mesh.positions.size(), Vec(0.0));
  for (const Triangle& t : mesh.triangles) {
    const Vec normal =
        glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    const double area = glm::length(normal);
    if (!(area > 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec e = mesh.positions[t[(k + 1) % 3]] - mesh.positions[t[k]];
      const Vec f = mesh.positions[t[(k + 2) % 3]] - mesh.positions[t[k]];
      const double cosine = glm::dot(e, f) / (glm::length(e) * glm::length(f));
      normals[t[k]] += normal / area * std::acos(std::clamp(cosine, -1.0, 1.0));
    }
  }
  for (Vec& n : normals) n = glm::length(n) > 0 ? glm::normalize(n) : Vec(0, 0, 1);
  return normals;
}

Mesh SplitCreases(const Mesh& mesh, double angle_deg) {
  const double least = std::cos(angle_deg * 3.14159265358979323846 / 180);
  const auto normal_of = [&mesh](const Triangle& t) {
    const Vec n = glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    return glm::length(n) > 0 ? glm::normalize(n) : Vec(0, 0, 1);
  };
  // Of each vertex: its copies so far, each with the normal of the first face that uses it.
  std::vector<std::vector<std::pair<Vec, std::uint32_t>>> copies(mesh.positions.size());
  Mesh split;
  split.groups = mesh.groups;
  for (const Triangle& t : mesh.triangles) {
    const Vec normal = normal_of(t);
    Triangle out{};
    for (std::size_t k = 0; k < 3; ++k) {
      auto& known = copies[t[k]];
      const auto found =
          std::find_if(known.begin(), known.end(), [&](const auto& c) { return glm::dot(c.first, normal) > least; });
      out[k] = found != known.end() ? found->second : static_cast<std::uint32_t>(split.positions.size());
      if (found != known.end()) continue;
      known.emplace_back(normal, out[k]);
      split.positions.push_back(mesh.positions[t[k]]);
      if (!mesh.colours.empty()) split.colours.push_back(mesh.colours[t[k]]);
    }
    split.triangles.push_back(out);
  }
  return split;
}

std::size_t OpenEdges(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
  }
  std::size_t open = 0;
  for (const auto& [edge, count] : uses) {
    const auto back = uses.find({edge.second, edge.first});
    if (count != 1 || back == uses.end()) ++open;
  }
  return open;
}

void KeepLargestComponent(Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.triangles) {
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  std::vector<std::size_t> count(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles) ++count[root(t[0])];
  const auto largest = static_cast<std::uint32_t>(std::max_element(count.begin(), count.end()) - count.begin());
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return root(t[0]) != largest; });
  mesh.groups.clear();
  std::vector<std::uint32_t> number(mesh.positions.size(), 0xFFFFFFFF);
  std::vector<Vec> positions, colours;
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) {
      if (number[v] == 0xFFFFFFFF) {
        number[v] = static_cast<std::uint32_t>(positions.size());
        positions.push_back(mesh.positions[v]);
        if (!mesh.colours.empty()) colours.push_back(mesh.colours[v]);
      }
      v = number[v];
    }
  }
  mesh.positions = std::move(positions);
  mesh.colours = std::move(colours);
}

double SignedVolume6(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += glm::dot(mesh.positions[a], glm::cross(mesh.positions[b], mesh.positions[c]));
  }
  return sum;
}

}  // namespace omni::scenes
