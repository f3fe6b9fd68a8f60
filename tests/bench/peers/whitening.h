// Applies a PeerScan's whitening to residuals and Jacobian columns of any scalar.
#pragma once

#include <cstddef>

#include "tests/bench/peers/peer.h"

namespace omni::peers {

// values: kPeerReadings of them, `stride` apart. values -= U (U^T values), column by column: they are orthogonal.
template <class T>
void RemoveNuisance(const PeerScan& scan, T* values, std::size_t stride) {
  for (std::size_t k = 0; k < scan.nuisances; ++k) {
    T along(0.0);
    for (std::size_t row = 0; row < kPeerReadings; ++row) {
      along += scan.nuisance_basis[kPeerNuisances * row + k] * values[stride * row];
    }
    for (std::size_t row = 0; row < kPeerReadings; ++row) {
      values[stride * row] -= scan.nuisance_basis[kPeerNuisances * row + k] * along;
    }
  }
}

}  // namespace omni::peers
