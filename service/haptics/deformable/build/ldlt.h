// L D L^T of a sparse symmetric positive definite matrix in the order it is given; can be stopped while it runs, which
// takes seconds for some thousand nodes. Set-up only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace omni::haptics {

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
