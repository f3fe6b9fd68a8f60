#include "service/haptics/geometry/mesh_steps.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "service/base/free_memory.h"
#include "service/haptics/geometry/winding_number.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

constexpr std::size_t kSamples = 16;                     // of a component, equal parts of its area ...
constexpr std::size_t kMaxSamples = 1024;                // ... of all together; each asked has one at least
constexpr std::size_t kMaxWindingTriangles = 2'000'000;  // larger meshes of many parts: by the sign of volumes alone
constexpr std::size_t kFewTriangles = 4;                 // an open part of fewer encloses nothing: it is not asked
constexpr int kMaxRounds = 8;
constexpr std::size_t kOpenSamples = 128;    // of all open parts together
constexpr std::int64_t kOpenWork = 100'000;  // for them, as kWork
constexpr double kInsideOut = -0.25;         // half of what an inside-out solid has
constexpr double kSure = 0.02;               // a sheet's winding number on itself is 0, within the tree's error

// What may be spent, in nodes and triangles visited: about as much as the rest of the build takes.
constexpr std::uint64_t kWork = 200'000, kWorkPerTriangle = 32;
constexpr std::uint64_t kComparedPerWork = 4;  // pairs of boxes

struct Part {
  double volume_m3 = 0;  // signed; of an open part, closed by its middle
  double area_m2 = 0;
  std::uint32_t triangles = 0;
  bool closed = true;
  Vec3 middle;
  Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
  std::vector<std::uint32_t> samples;  // triangles
};

bool PartContains(const Part& outer, const Part& inner) {
  return outer.lower.x < inner.lower.x && outer.lower.y < inner.lower.y && outer.lower.z < inner.lower.z &&
         outer.upper.x > inner.upper.x && outer.upper.y > inner.upper.y && outer.upper.z > inner.upper.z;
}

double TriangleArea(const Mesh& mesh, std::uint32_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return 0.5 * Norm(Cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
}

// V = 1/6 sum a . (b x c), relative to the part's middle: meshes far away keep their digits, and an open part gets the
// volume between it and its middle.
std::vector<Part> PartsOf(const Mesh& mesh, std::uint32_t count, const base::WorkWatch& watch) {
  std::vector<Part> parts(count);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    watch.Did(2);
    Part& part = parts[mesh.component[t]];
    const auto& [a, b, c] = mesh.triangles[t];
    const double area_m2 = TriangleArea(mesh, t);
    part.area_m2 += area_m2;
    part.middle = part.middle + (area_m2 / 3) * (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]);
    ++part.triangles;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& v = mesh.vertices[mesh.triangles[t][k]];
      part.lower = Min(part.lower, v);
      part.upper = Max(part.upper, v);
      part.closed = part.closed && mesh.neighbours[t][k] != kNoIndex;
    }
  }
  for (Part& part : parts) part.middle = part.area_m2 > 0 ? (1 / part.area_m2) * part.middle : part.lower;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Part& part = parts[mesh.component[t]];
    const auto& [a, b, c] = mesh.triangles[t];
    part.volume_m3 +=
        Dot(mesh.vertices[a] - part.middle, Cross(mesh.vertices[b] - part.middle, mesh.vertices[c] - part.middle)) / 6;
  }
  return parts;
}

// Which parts may be wrong. A closed one of positive volume is right: only what lies around it, turned inside-out,
// could make its winding number negative. Largest first.
std::vector<std::uint32_t> Doubtful(const std::vector<Part>& parts, const base::WorkWatch& watch) {
  std::vector<std::uint32_t> doubtful;
  for (std::uint32_t p = 0; p < parts.size(); ++p) {
    const Part& part = parts[p];
    if (part.closed ? part.volume_m3 < 0 : part.triangles >= kFewTriangles) doubtful.push_back(p);
  }
  std::sort(doubtful.begin(), doubtful.end(), [&](std::uint32_t a, std::uint32_t b) {
    watch.Did();
    return parts[a].area_m2 != parts[b].area_m2 ? parts[a].area_m2 > parts[b].area_m2 : a < b;
  });
  return doubtful;
}

// Asks for winding numbers until the work is spent; then the sign of volumes decides.
class Turner {
 public:
  Turner(Mesh& mesh, std::vector<Part>& parts, OrientReport& report, const base::WorkWatch& watch)
      : mesh_(mesh),
        parts_(parts),
        report_(report),
        watch_(watch),
        flip_(parts.size(), false),
        winding_(parts.size(), 0),
        left_(static_cast<std::int64_t>(kWork + kWorkPerTriangle * mesh.triangles.size())) {}

  void ByWinding(const std::vector<std::uint32_t>& doubtful) {
    PickSamples(doubtful);
    WindingTree& tree = Tree();
    std::vector<std::uint32_t> asked = doubtful, unasked;
    for (int round = 0; round < kMaxRounds; ++round) {
      std::vector<std::uint32_t> wrong;
      std::size_t next = 0;
      for (; next < asked.size() && left_ > 0; ++next) {
        const std::uint32_t p = asked[next];
        winding_[p] = WindingOn(tree, parts_[p]);
        if (winding_[p] < -kSure) wrong.push_back(p);
      }
      if (round == 0) unasked.assign(asked.begin() + static_cast<std::ptrdiff_t>(next), asked.end());
      asked.resize(next);
      if (wrong.empty() || left_ <= 0) {
        for (const std::uint32_t p : wrong) Mark(p);
        break;
      }
      FlipOutermost(wrong);
      std::erase_if(asked, [&](std::uint32_t p) { return parts_[p].closed && parts_[p].volume_m3 >= 0; });
      left_ -= static_cast<std::int64_t>(mesh_.triangles.size());
      Tree();
    }
    report_.by_volume = static_cast<std::uint32_t>(unasked.size());
    ByVolume(unasked);
    for (const std::uint32_t p : doubtful)
      report_.cavities += parts_[p].closed && parts_[p].volume_m3 < 0 && winding_[p] > kSure;
  }

  // The last question: mean winding number on the open parts, which says whether they are walls of a solid. Of loose
  // triangles, which are not asked one by one, it also says whether they are inside-out.
  void AskOpen() {
    double area_m2 = 0;
    std::vector<bool> open(parts_.size()), loose(parts_.size());
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      open[p] = !parts_[p].closed;
      loose[p] = open[p] && parts_[p].triangles < kFewTriangles;
      area_m2 += open[p] ? parts_[p].area_m2 : 0;
    }
    std::vector<std::uint32_t> samples;
    double passed_m2 = 0;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      watch_.Did();
      if (!open[mesh_.component[t]]) continue;
      passed_m2 += TriangleArea(mesh_, t);
      const double next = (static_cast<double>(samples.size()) + 0.5) / kOpenSamples * area_m2;
      if (samples.size() < kOpenSamples && passed_m2 >= next) samples.push_back(t);
    }
    // Of loose triangles there are as many parts, which take more than the tree.
    base::FreeMemory(parts_);
    base::FreeMemory(winding_);
    std::int64_t left = kOpenWork;
    report_.solidity = MeanWinding(Tree(), samples, left);
    if (report_.solidity > kInsideOut) return;
    flip_ = loose;
    report_.flipped += static_cast<std::uint32_t>(std::count(loose.begin(), loose.end(), true));
    Flip();
    report_.solidity = MeanWinding(Tree(), samples, left);
  }

  void ByVolume(const std::vector<std::uint32_t>& doubtful) {
    for (const std::uint32_t p : doubtful) {
      if (parts_[p].volume_m3 < 0) Mark(p);
    }
    Flip();
  }

 private:
  // One triangle of each of some equal parts of the area, in the order of the mesh.
  void PickSamples(const std::vector<std::uint32_t>& doubtful) {
    const std::size_t each = std::clamp<std::size_t>(kMaxSamples / doubtful.size(), 1, kSamples);
    std::vector<bool> wanted(parts_.size(), false);
    for (const std::uint32_t p : doubtful) wanted[p] = true;
    std::vector<double> passed(parts_.size(), 0);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      watch_.Did();
      if (!wanted[mesh_.component[t]]) continue;
      Part& part = parts_[mesh_.component[t]];
      double& area = passed[mesh_.component[t]];
      area += TriangleArea(mesh_, t);
      const double next = (static_cast<double>(part.samples.size()) + 0.5) / static_cast<double>(each) * part.area_m2;
      if (part.samples.size() < each && area >= next) part.samples.push_back(t);
    }
  }

  // Mean winding number on the part itself. Its front lies 1/2 lower, its back 1/2 higher: a wall of a solid has
  // n + 1/2 with n >= 0 solids in front of it, an inside-out one less than 0   (R.6)
  double WindingOn(const WindingTree& tree, const Part& part) {
    std::int64_t enough = std::numeric_limits<std::int64_t>::max();
    const std::int64_t before = enough;
    const double mean = MeanWinding(tree, part.samples, enough);
    left_ -= before - enough;
    return mean;
  }

  // Of as many samples as can be asked for the work in `left`.
  double MeanWinding(const WindingTree& tree, const std::vector<std::uint32_t>& samples, std::int64_t& left) {
    double sum = 0;
    std::size_t asked = 0;
    for (; asked < samples.size() && left > 0; ++asked) {
      const std::uint32_t t = samples[asked];
      std::uint64_t visited = 0;
      const auto& [a, b, c] = mesh_.triangles[t];
      sum += tree.At((1.0 / 3) * (mesh_.vertices[a] + mesh_.vertices[b] + mesh_.vertices[c]), t, visited);
      watch_.Did(1 + visited / 16);  // tens of nanoseconds each
      left -= static_cast<std::int64_t>(visited);
    }
    return asked == 0 ? 0 : sum / static_cast<double>(asked);
  }

  // As the triangles are turned now.
  WindingTree& Tree() {
    if (!tree_) {
      tree_.emplace(mesh_, watch_);
    } else if (turned_) {
      tree_->Refit();
    }
    turned_ = false;
    return *tree_;
  }

  // Of the parts that are wrong, those that lie in no other wrong one are flipped; what they contain is asked again,
  // because its winding number counts them. What contains a box has a larger one.
  void FlipOutermost(std::vector<std::uint32_t> wrong) {
    const auto size = [&](std::uint32_t p) { return SquaredNorm(parts_[p].upper - parts_[p].lower); };
    std::stable_sort(wrong.begin(), wrong.end(), [&](std::uint32_t a, std::uint32_t b) { return size(a) > size(b); });
    std::vector<std::uint32_t> outermost;
    for (const std::uint32_t inner : wrong) {
      const auto contains = [&](std::uint32_t outer) { return PartContains(parts_[outer], parts_[inner]); };
      watch_.Did(1 + outermost.size() / 8);
      left_ -= static_cast<std::int64_t>(outermost.size() / kComparedPerWork);
      if (left_ > 0 && std::any_of(outermost.begin(), outermost.end(), contains)) continue;
      outermost.push_back(inner);
      Mark(inner);
    }
    Flip();
  }

  void Mark(std::uint32_t p) {
    flip_[p] = true;
    parts_[p].volume_m3 = -parts_[p].volume_m3;
    ++report_.flipped;
  }

  void Flip() {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      watch_.Did();
      if (flip_[mesh_.component[t]]) haptics::Flip(mesh_, t);
    }
    flip_.assign(flip_.size(), false);
    turned_ = true;
  }

  Mesh& mesh_;
  std::vector<Part>& parts_;
  OrientReport& report_;
  const base::WorkWatch& watch_;
  std::vector<bool> flip_;
  std::vector<double> winding_;
  std::optional<WindingTree> tree_;
  bool turned_ = false;  // since the tree was made
  std::int64_t left_;    // work
};

}  // namespace

OrientReport OrientOutwards(Mesh& mesh, std::uint32_t components, const base::WorkWatch& watch) {
  OrientReport report;
  std::vector<Part> parts = PartsOf(mesh, components, watch);
  const std::vector<std::uint32_t> doubtful = Doubtful(parts, watch);
  const bool open = std::any_of(parts.begin(), parts.end(), [](const Part& part) { return !part.closed; });
  if (doubtful.empty() && !open) return report;
  Turner turner(mesh, parts, report, watch);
  if (doubtful.empty()) {
    // Only loose triangles.
  } else if (components == 1 && parts[0].closed) {  // the sign of its volume says all
    turner.ByVolume(doubtful);
  } else if (mesh.triangles.size() > kMaxWindingTriangles) {
    report.by_volume = static_cast<std::uint32_t>(doubtful.size());
    turner.ByVolume(doubtful);
  } else {
    turner.ByWinding(doubtful);
  }
  if (open && mesh.triangles.size() <= kMaxWindingTriangles) turner.AskOpen();
  return report;
}

}  // namespace omni::haptics
