#include "service/haptics/deformable/capacitance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace omni::haptics {
namespace {

constexpr int kMaxChanges = 4 * kMaxSoftContacts;  // of the set, in one call
constexpr double kSmallestPivot = 1e-12;           // of the diagonal
constexpr double kLeftOver = 1e-10;                // of the depth: what still counts as touching

std::size_t U(int i) { return static_cast<std::size_t>(i); }

bool IsIn(const ActiveFactor& factor, int node) noexcept {
  for (int k = 0; k < factor.count; ++k) {
    if (factor.node[U(k)] == node) return true;
  }
  return false;
}

// The node outside S that is pressed in most beyond the displacement that the others cause; -1: none.
int DeepestOutside(const ContactMatrix& a, int count, const ContactVector& depth_m, const ActiveFactor& factor,
                   const ContactVector& force) noexcept {
  int worst = -1;
  double worst_m = 0;
  for (int i = 0; i < count; ++i) {
    if (IsIn(factor, i)) continue;
    double left_m = depth_m[U(i)];
    for (int k = 0; k < factor.count; ++k) left_m -= a[U(i)][U(factor.node[U(k)])] * force[U(factor.node[U(k)])];
    if (left_m > worst_m && left_m > kLeftOver * std::abs(depth_m[U(i)])) {
      worst_m = left_m;
      worst = i;
    }
  }
  return worst;
}

}  // namespace

bool AddNode(const ContactMatrix& a, int node, ActiveFactor& factor) noexcept {
  const int n = factor.count;
  if (n >= kMaxSoftContacts) return false;
  auto& row = factor.lower[U(n)];
  double rest = a[U(node)][U(node)];
  for (int i = 0; i < n; ++i) {
    double sum = a[U(node)][U(factor.node[U(i)])];
    for (int j = 0; j < i; ++j) sum -= factor.lower[U(i)][U(j)] * row[U(j)];
    row[U(i)] = sum / factor.lower[U(i)][U(i)];
    rest -= row[U(i)] * row[U(i)];
  }
  if (!(rest > kSmallestPivot * a[U(node)][U(node)])) return false;
  row[U(n)] = std::sqrt(rest);
  factor.node[U(n)] = node;
  ++factor.count;
  return true;
}

void RemoveNode(int position, ActiveFactor& factor) noexcept {
  auto& l = factor.lower;
  for (int i = position; i + 1 < factor.count; ++i) {
    l[U(i)] = l[U(i + 1)];
    factor.node[U(i)] = factor.node[U(i + 1)];
  }
  --factor.count;
  for (int k = position; k < factor.count; ++k) {
    const double x = l[U(k)][U(k)];
    const double y = l[U(k)][U(k + 1)];
    const double r = std::sqrt(x * x + y * y);
    const double c = x / r;
    const double s = y / r;
    for (int i = k; i < factor.count; ++i) {
      const double p = l[U(i)][U(k)];
      const double q = l[U(i)][U(k + 1)];
      l[U(i)][U(k)] = c * p + s * q;
      l[U(i)][U(k + 1)] = c * q - s * p;
    }
  }
}

void SolveActive(const ActiveFactor& factor, const ContactVector& b, ContactVector& x) noexcept {
  ContactVector y{};
  const auto& l = factor.lower;
  for (int i = 0; i < factor.count; ++i) {
    double sum = b[U(factor.node[U(i)])];
    for (int j = 0; j < i; ++j) sum -= l[U(i)][U(j)] * y[U(j)];
    y[U(i)] = sum / l[U(i)][U(i)];
  }
  for (int i = factor.count - 1; i >= 0; --i) {
    y[U(i)] /= l[U(i)][U(i)];
    for (int j = 0; j < i; ++j) y[U(j)] -= l[U(i)][U(j)] * y[U(i)];
  }
  for (int i = 0; i < factor.count; ++i) x[U(factor.node[U(i)])] = y[U(i)];
}

// Sum of squares of the columns of L^-1.
void InverseDiagonal(const ActiveFactor& factor, ContactVector& diagonal) noexcept {
  const auto& l = factor.lower;
  for (int column = 0; column < factor.count; ++column) {
    ContactVector y{};
    double sum = 0;
    for (int i = column; i < factor.count; ++i) {
      double v = i == column ? 1 : 0;
      for (int j = column; j < i; ++j) v -= l[U(i)][U(j)] * y[U(j)];
      y[U(i)] = v / l[U(i)][U(i)];
      sum += y[U(i)] * y[U(i)];
    }
    diagonal[U(factor.node[U(column)])] = sum;
  }
}

// Active set [Lawson & Hanson 1974, NNLS, chapter 23]: solve on S; step towards it until a force would turn into a
// pull, drop that node; when all are positive, take in the node pressed in most.   (6.1)
bool SolveContact(const ContactMatrix& a, int count, const ContactVector& depth_m, ActiveFactor& factor,
                  ContactVector& force) noexcept {
  for (int i = 0; i < kMaxSoftContacts; ++i) {
    if (i >= count || !IsIn(factor, i)) force[U(i)] = 0;
  }
  for (int change = 0; change < kMaxChanges; ++change) {
    ContactVector wanted{};
    SolveActive(factor, depth_m, wanted);
    double step = 1;
    int drop = -1;
    for (int k = 0; k < factor.count; ++k) {
      const int i = factor.node[U(k)];
      if (wanted[U(i)] > 0) continue;
      const double room = force[U(i)] > 0 ? force[U(i)] / (force[U(i)] - wanted[U(i)]) : 0;
      if (drop < 0 || room < step) {
        step = room;
        drop = k;
      }
    }
    for (int k = 0; k < factor.count; ++k) {
      double& f = force[U(factor.node[U(k)])];
      f = std::max(0.0, f + step * (wanted[U(factor.node[U(k)])] - f));
    }
    if (drop >= 0) {
      force[U(factor.node[U(drop)])] = 0;
      RemoveNode(drop, factor);
      continue;
    }
    const int deepest = DeepestOutside(a, count, depth_m, factor, force);
    if (deepest < 0) return true;
    if (!AddNode(a, deepest, factor)) return false;
  }
  return false;
}

}  // namespace omni::haptics
