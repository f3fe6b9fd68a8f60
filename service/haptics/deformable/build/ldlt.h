// L D L^T of a sparse symmetric positive definite matrix, and an order of elimination that keeps it small. It can be
// stopped while it runs, which takes seconds for some thousand nodes. Set-up only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

// Order in which to eliminate `nodes`: nested dissection by coordinates [George 1973]. `neighbours[n]` of every node n.
std::vector<std::uint32_t> DissectionOrder(const std::vector<Vec3>& position, std::vector<std::uint32_t> nodes,
                                           const std::vector<std::vector<std::uint32_t>>& neighbours);

// The upper triangle with its diagonal, by columns: entries first[j] ... first[j + 1] - 1 are in column j.
struct UpperColumns {
  std::span<const int> first;  // one more than there are columns
  std::span<const int> row;
  std::span<const double> value;
};

// L without its diagonal of ones, by columns, rows ascending; D.
struct LdltFactor {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> row;
  std::vector<double> value;
  std::vector<double> diagonal;
};

enum class LdltOutcome { kDone, kNotPositive, kStopped };

// Up-looking: row after row, along the elimination tree [Davis, Algorithm 849: LDL, 2005]. `go_on` is called every few
// milliseconds with the share that is done, 0 ... 1; empty: never.
LdltOutcome FactoriseLdlt(const UpperColumns& matrix, const std::function<bool(double done)>& go_on,
                          LdltFactor& factor);

}  // namespace omni::haptics
