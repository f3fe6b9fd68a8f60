#include "service/haptics/contact/half_spaces.h"

#include <limits>

namespace omni::haptics {
namespace {

constexpr double kParallel = 1e-12;    // squared sine below which two planes have no line in common
constexpr std::size_t kMaxTight = 12;  // planes through the nearest point that are checked

// Gauss elimination of a symmetric positive system of up to three; unknowns without a pivot stay 0.
std::array<double, kMaxActive> SolveGram(std::array<std::array<double, kMaxActive>, kMaxActive> gram,
                                         std::array<double, kMaxActive> right, std::size_t count) noexcept {
  std::array<bool, kMaxActive> used{};
  for (std::size_t k = 0; k < count; ++k) {
    used[k] = gram[k][k] > kParallel;
    for (std::size_t row = k + 1; used[k] && row < count; ++row) {
      const double factor = gram[row][k] / gram[k][k];
      for (std::size_t column = k; column < count; ++column) gram[row][column] -= factor * gram[k][column];
      right[row] -= factor * right[k];
    }
  }
  std::array<double, kMaxActive> x{};
  for (std::size_t k = count; k-- > 0;) {
    if (!used[k]) continue;
    x[k] = right[k];
    for (std::size_t column = k + 1; column < count; ++column) x[k] -= gram[k][column] * x[column];
    x[k] /= gram[k][k];
  }
  return x;
}

// m of least |sum m_k normal_k - push|, of either sign, for the active planes.
std::array<double, kMaxActive> FitOf(const NearestInside& inside, std::span<const HalfSpace> spaces,
                                     const Vec3& push) noexcept {
  const auto count = static_cast<std::size_t>(inside.active_count);
  std::array<std::array<double, kMaxActive>, kMaxActive> gram{};
  std::array<double, kMaxActive> right{};
  const auto normal = [&](std::size_t k) noexcept { return spaces[static_cast<std::size_t>(inside.active[k])].normal; };
  for (std::size_t i = 0; i < count; ++i) {
    right[i] = Dot(normal(i), push);
    for (std::size_t j = 0; j < count; ++j) gram[i][j] = Dot(normal(i), normal(j));
  }
  return SolveGram(gram, right, count);
}

// One half-space after the other. Where the answer so far violates the next one, the new answer lies on its plane: the
// same problem with one dimension less, over those before   [Seidel 1991].
class HalfSpaceSearch {
 public:
  HalfSpaceSearch(const Vec3& goal, std::span<const HalfSpace> spaces, double tolerance) noexcept
      : goal_(goal), spaces_(spaces), tolerance_(tolerance) {}

  NearestInside Run() noexcept {
    best_.point = goal_;
    for (std::size_t i = 0; i < spaces_.size() && best_.feasible; ++i) {
      if (Violates(i)) best_.feasible = OnPlane(i);
    }
    if (best_.feasible && !Pushes(best_)) ChoosePushing();
    return best_;
  }

 private:
  bool Violates(std::size_t i) const noexcept {
    return Dot(spaces_[i].normal, best_.point) < spaces_[i].offset - tolerance_;
  }
  // Does a push from every active plane hold the goal at the point?
  bool Pushes(const NearestInside& inside) const noexcept {
    const Vec3 push = inside.point - goal_;
    const auto fit = FitOf(inside, spaces_, push);
    Vec3 rest = push;
    for (std::size_t k = 0; k < static_cast<std::size_t>(inside.active_count); ++k) {
      if (fit[k] < 0) return false;
      rest = rest - fit[k] * spaces_[static_cast<std::size_t>(inside.active[k])].normal;
    }
    return SquaredNorm(rest) <= 1e-12 * SquaredNorm(push);
  }

  // Where more planes than three meet in the point, not every three of them push; some three do   [Caratheodory].
  void ChoosePushing() noexcept {
    std::array<int, kMaxTight> tight{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < spaces_.size() && count < kMaxTight; ++k) {
      const double over = Dot(spaces_[k].normal, best_.point) - spaces_[k].offset;
      if (over <= 10 * tolerance_) tight[count++] = static_cast<int>(k);
    }
    NearestInside choice = best_;
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = a + 1; b < count; ++b) {
        choice.active = {tight[a], tight[b], 0};
        choice.active_count = 2;
        bool found = Pushes(choice);
        for (std::size_t c = b + 1; c < count && !found; ++c) {
          choice.active[2] = tight[c];
          choice.active_count = 3;
          found = Pushes(choice);
        }
        if (!found) continue;
        best_ = choice;
        return;
      }
    }
  }

  double Missing(std::size_t i) const noexcept { return spaces_[i].offset - Dot(spaces_[i].normal, goal_); }

  bool OnPlane(std::size_t i) noexcept {
    best_.point = goal_ + Missing(i) * spaces_[i].normal;
    best_.active_count = 1;
    best_.active[0] = static_cast<int>(i);
    for (std::size_t j = 0; j < i; ++j) {
      if (Violates(j) && !OnLine(i, j)) return false;
    }
    return true;
  }

  // p = goal + a n_i + b n_j + s u: the first three are the point of the line nearest to the goal, u runs along it.
  bool OnLine(std::size_t i, std::size_t j) noexcept {
    const Vec3 &n_i = spaces_[i].normal, &n_j = spaces_[j].normal;
    const Vec3 along = Cross(n_i, n_j);
    const double det = SquaredNorm(along), cosine = Dot(n_i, n_j);
    if (!(det > kParallel)) return false;
    const double a = (Missing(i) - cosine * Missing(j)) / det, b = (Missing(j) - cosine * Missing(i)) / det;
    const Vec3 foot = goal_ + a * n_i + b * n_j, u = (1 / std::sqrt(det)) * along;
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    std::size_t low_by = 0, high_by = 0;
    for (std::size_t k = 0; k < j; ++k) {
      const double slope = Dot(spaces_[k].normal, u);
      const double missing = spaces_[k].offset - Dot(spaces_[k].normal, foot);
      if (missing <= tolerance_ && std::abs(slope) < 1e-9) continue;
      const double bound = (missing - tolerance_) / slope;
      if (slope >= 0 && bound > low) {
        low = bound;
        low_by = k;
      } else if (slope < 0 && bound < high) {
        high = bound;
        high_by = k;
      }
    }
    if (low > high) return false;
    const double s = low > 0 ? low : std::min(high, 0.0);
    best_.point = foot + s * u;
    best_.active_count = s == 0 ? 2 : 3;
    best_.active = {static_cast<int>(i), static_cast<int>(j), static_cast<int>(s > 0 ? low_by : high_by)};
    return true;
  }

  const Vec3 goal_;
  const std::span<const HalfSpace> spaces_;
  const double tolerance_;
  NearestInside best_;
};

}  // namespace

NearestInside NearestInHalfSpaces(const Vec3& goal, std::span<const HalfSpace> spaces, double tolerance) noexcept {
  return HalfSpaceSearch(goal, spaces, tolerance).Run();
}

std::array<double, kMaxActive> Multipliers(const NearestInside& inside, std::span<const HalfSpace> spaces,
                                           const Vec3& push) noexcept {
  std::array<double, kMaxActive> result = FitOf(inside, spaces, push);
  for (double& m : result) m = std::max(m, 0.0);
  return result;
}

}  // namespace omni::haptics
