#include "service/haptics/deformable/build/ldlt.h"

#include "service/base/free_memory.h"

namespace omni::haptics {
namespace {

constexpr std::size_t kSmallSet = 24;

double Coordinate(const Vec3& v, int axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

struct Dissection {
  const std::vector<Vec3>& position;
  const std::vector<std::vector<std::uint32_t>>& neighbours;
  std::vector<std::uint32_t> side;  // of every node: 2 call + half
  std::vector<std::uint32_t> order;
  std::uint32_t calls = 0;

  int LongestAxis(const std::vector<std::uint32_t>& nodes) const {
    Vec3 lower = position[nodes[0]];
    Vec3 upper = lower;
    for (const std::uint32_t n : nodes) {
      lower = Min(lower, position[n]);
      upper = Max(upper, position[n]);
    }
    const Vec3 e = upper - lower;
    return e.x >= e.y && e.x >= e.z ? 0 : (e.y >= e.z ? 1 : 2);
  }

  // Halves first, then the nodes of the lower half that touch the upper one.
  void Run(std::vector<std::uint32_t> nodes) {
    if (nodes.size() <= kSmallSet) {
      order.insert(order.end(), nodes.begin(), nodes.end());
      return;
    }
    const int axis = LongestAxis(nodes);
    const auto middle = nodes.begin() + static_cast<std::ptrdiff_t>(nodes.size() / 2);
    std::nth_element(nodes.begin(), middle, nodes.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double ca = Coordinate(position[a], axis);
      const double cb = Coordinate(position[b], axis);
      return ca < cb || (ca == cb && a < b);
    });
    const std::uint32_t upper_mark = 2 * ++calls + 1;
    std::vector<std::uint32_t> upper(middle, nodes.end());
    for (const std::uint32_t n : upper) side[n] = upper_mark;
    std::vector<std::uint32_t> lower;
    std::vector<std::uint32_t> between;
    for (auto n = nodes.begin(); n != middle; ++n) {
      const auto& around = neighbours[*n];
      const bool touches =
          std::any_of(around.begin(), around.end(), [&](std::uint32_t m) { return side[m] == upper_mark; });
      (touches ? between : lower).push_back(*n);
    }
    base::FreeMemory(nodes);
    Run(std::move(lower));
    Run(std::move(upper));
    order.insert(order.end(), between.begin(), between.end());
  }
};

}  // namespace

std::vector<std::uint32_t> DissectionOrder(const std::vector<Vec3>& position, std::vector<std::uint32_t> nodes,
                                           const std::vector<std::vector<std::uint32_t>>& neighbours) {
  Dissection dissection{position, neighbours, std::vector<std::uint32_t>(position.size(), 0), {}, 0};
  dissection.order.reserve(nodes.size());
  dissection.Run(std::move(nodes));
  return std::move(dissection.order);
}

namespace {

constexpr std::uint32_t kNoParent = 0xFFFFFFFF;
constexpr std::size_t kWorkPerQuestion = 4'000'000;  // multiplications between two calls

class LdltBuilder {
 public:
  LdltBuilder(const UpperColumns& matrix, LdltFactor& factor)
      : matrix_(matrix),
        factor_(factor),
        size_(matrix.first.size() - 1),
        parent_(size_, kNoParent),
        seen_(size_, kNoParent),
        filled_(size_, 0),
        pattern_(size_),
        path_(size_),
        y_(size_, 0) {}

  // Elimination tree and room for L.
  void Symbolic() {
    for (std::uint32_t k = 0; k < size_; ++k) {
      seen_[k] = k;
      for (std::size_t p = Begin(k); p < Begin(k + 1); ++p) {
        for (std::uint32_t i = Row(p); seen_[i] != k; i = parent_[i]) {
          if (parent_[i] == kNoParent) parent_[i] = k;
          ++filled_[i];
          seen_[i] = k;
        }
      }
    }
    factor_.first.assign(size_ + 1, 0);
    for (std::size_t k = 0; k < size_; ++k) factor_.first[k + 1] = factor_.first[k] + filled_[k];
    factor_.row.resize(factor_.first[size_]);
    factor_.value.resize(factor_.first[size_]);
    factor_.diagonal.assign(size_, 0);
    filled_.assign(size_, 0);
    seen_.assign(size_, kNoParent);
  }

  LdltOutcome Numeric(const std::function<bool(double)>& go_on) {
    std::size_t work = 0;
    for (std::uint32_t k = 0; k < size_; ++k) {
      const std::size_t top = Scatter(k);
      for (std::size_t t = top; t < size_; ++t) work += Eliminate(pattern_[t], k);
      if (!(factor_.diagonal[k] > 0)) return LdltOutcome::kNotPositive;
      if (work < kWorkPerQuestion || !go_on) continue;
      work = 0;
      if (!go_on(static_cast<double>(entries_) / static_cast<double>(factor_.row.size()))) return LdltOutcome::kStopped;
    }
    return LdltOutcome::kDone;
  }

 private:
  std::size_t Begin(std::uint32_t column) const { return static_cast<std::size_t>(matrix_.first[column]); }
  std::uint32_t Row(std::size_t entry) const { return static_cast<std::uint32_t>(matrix_.row[entry]); }

  // Puts column k into y and the columns of L that row k uses into pattern_, in the order of elimination; where they
  // start there.
  std::size_t Scatter(std::uint32_t k) {
    std::size_t top = size_;
    seen_[k] = k;
    for (std::size_t p = Begin(k); p < Begin(k + 1); ++p) {
      std::uint32_t i = Row(p);
      y_[i] += matrix_.value[p];
      std::size_t length = 0;
      for (; seen_[i] != k; i = parent_[i]) {
        path_[length++] = i;
        seen_[i] = k;
      }
      while (length > 0) pattern_[--top] = path_[--length];
    }
    factor_.diagonal[k] = y_[k];
    y_[k] = 0;
    return top;
  }

  // l_ki = y_i / d_i; y -= L_i y_i; d_k -= l_ki y_i. The multiplications it took.
  std::size_t Eliminate(std::uint32_t i, std::uint32_t k) {
    const double y = y_[i];
    y_[i] = 0;
    const std::size_t first = factor_.first[i], count = filled_[i]++;
    for (std::size_t p = first; p < first + count; ++p) y_[factor_.row[p]] -= factor_.value[p] * y;
    const double l = y / factor_.diagonal[i];
    factor_.diagonal[k] -= l * y;
    factor_.row[first + count] = k;
    factor_.value[first + count] = l;
    ++entries_;
    return count + 1;
  }

  const UpperColumns& matrix_;
  LdltFactor& factor_;
  const std::size_t size_;
  std::vector<std::uint32_t> parent_, seen_;
  std::vector<std::size_t> filled_;  // entries of each column so far
  std::vector<std::uint32_t> pattern_, path_;
  std::vector<double> y_;
  std::size_t entries_ = 0;
};

}  // namespace

LdltOutcome FactoriseLdlt(const UpperColumns& matrix, const std::function<bool(double done)>& go_on,
                          LdltFactor& factor) {
  factor = {};
  LdltBuilder builder(matrix, factor);
  builder.Symbolic();
  return builder.Numeric(go_on);
}

}  // namespace omni::haptics
