// Contact through the capacitance matrix [James & Pai 1999]: given A (compliance between contact nodes, symmetric
// positive definite) and how deep each node is pressed in, find f >= 0 with A f - d >= 0 and f . (A f - d) = 0. Runs in
// the tick: fixed size, no allocation. docs/theory/deformable.md, section 6.
#pragma once

#include <array>

namespace omni::haptics {

inline constexpr int kMaxSoftContacts = 16;
using ContactVector = std::array<double, kMaxSoftContacts>;
using ContactMatrix = std::array<ContactVector, kMaxSoftContacts>;

// Cholesky factor L of A_SS, S = the nodes that carry force, in the order they were added.   (6.2)
struct ActiveFactor {
  int count = 0;
  std::array<int, kMaxSoftContacts> node{};
  ContactMatrix lower{};
};

// l = L^-1 a_S, l_nn = sqrt(a_nn - l . l): O(n^2). False, and nothing changed, if that is no positive number.
bool AddNode(const ContactMatrix& a, int node, ActiveFactor& factor) noexcept;
// Takes out the node at `position` of the factor's order; Givens rotations restore the rest: O(n^2).
void RemoveNode(int position, ActiveFactor& factor) noexcept;
// A_SS x = b_S; x outside S is left alone.
void SolveActive(const ActiveFactor& factor, const ContactVector& b, ContactVector& x) noexcept;
// (A_SS^-1)_kk for the nodes of S.
void InverseDiagonal(const ActiveFactor& factor, ContactVector& diagonal) noexcept;

// Solves for nodes 0 .. count - 1 from the set in `factor`, whose L must belong to `a` (see AddNode); a warm start that
// is already right costs one solve. Ends with the exact solution; false if it had to stop first (`force` is then
// feasible, not exact: f >= 0). `force` in: last solution, or zero.
bool SolveContact(const ContactMatrix& a, int count, const ContactVector& depth_m, ActiveFactor& factor,
                  ContactVector& force) noexcept;

}  // namespace omni::haptics
