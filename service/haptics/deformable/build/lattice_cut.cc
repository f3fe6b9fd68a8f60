#include "service/haptics/deformable/build/lattice.h"

#include <algorithm>

namespace omni::haptics {
namespace {

// Quad base in order, apex.
void SplitPyramid(const TetCorners& quad, std::uint32_t apex, std::vector<TetCorners>& pieces) {
  const auto smallest = std::min_element(quad.begin(), quad.end()) - quad.begin();
  const auto at = [&](std::ptrdiff_t k) { return quad[static_cast<std::size_t>((smallest + k) % 4)]; };
  pieces.push_back({at(0), at(1), at(2), apex});
  pieces.push_back({at(0), at(2), at(3), apex});
}

// Triangles v0 v1 v2 and v3 v4 v5, edges v0-v3, v1-v4, v2-v5.
void SplitPrism(std::array<std::uint32_t, 6> v, std::vector<TetCorners>& pieces) {
  const auto smallest = std::min_element(v.begin(), v.end()) - v.begin();
  if (smallest >= 3) v = {v[3], v[4], v[5], v[0], v[1], v[2]};
  const auto turn = static_cast<std::size_t>(smallest % 3);
  std::array<std::uint32_t, 6> t{};
  for (std::size_t k = 0; k < 3; ++k) {
    t[k] = v[(k + turn) % 3];
    t[k + 3] = v[(k + turn) % 3 + 3];
  }
  pieces.push_back({t[0], t[3], t[4], t[5]});
  if (std::min(t[1], t[5]) < std::min(t[2], t[4])) {
    pieces.push_back({t[0], t[1], t[2], t[5]});
    pieces.push_back({t[0], t[1], t[5], t[4]});
  } else {
    pieces.push_back({t[0], t[1], t[2], t[4]});
    pieces.push_back({t[0], t[4], t[2], t[5]});
  }
}

}  // namespace

void CutTet(const TetCorners& tet, const std::array<int, 4>& side,
            const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& cut, std::vector<TetCorners>& pieces) {
  std::array<std::uint32_t, 4> in{};
  std::array<std::uint32_t, 4> on{};
  std::array<std::uint32_t, 4> out{};
  std::size_t ins = 0;
  std::size_t ons = 0;
  std::size_t outs = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (side[k] > 0) in[ins++] = tet[k];
    if (side[k] == 0) on[ons++] = tet[k];
    if (side[k] < 0) out[outs++] = tet[k];
  }
  if (ins == 0) return;
  if (outs == 0) {
    pieces.push_back(tet);
  } else if (ins == 1) {
    TetCorners piece{in[0], in[0], in[0], in[0]};
    for (std::size_t k = 0; k < ons; ++k) piece[1 + k] = on[k];
    for (std::size_t k = 0; k < outs; ++k) piece[1 + ons + k] = cut(in[0], out[k]);
    pieces.push_back(piece);
  } else if (ins == 2 && outs == 1) {
    SplitPyramid({in[0], in[1], cut(in[1], out[0]), cut(in[0], out[0])}, on[0], pieces);
  } else if (ins == 2) {
    SplitPrism({in[0], cut(in[0], out[0]), cut(in[0], out[1]), in[1], cut(in[1], out[0]), cut(in[1], out[1])}, pieces);
  } else {
    SplitPrism({in[0], in[1], in[2], cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0])}, pieces);
  }
}

}  // namespace omni::haptics
