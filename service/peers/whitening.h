// Applies a PeerScan's whitening to residuals and Jacobian columns of any scalar.
#pragma once

#include <cstddef>

#include "service/peers/peer.h"

namespace omni::peers {

// values: kPeerReadings of them, `stride` apart. values -= U (U^T values)
template <class T>
void RemoveNuisance(const PeerScan& scan, T* values, std::size_t stride) {
  if (!scan.has_nuisance) return;
  std::array<T, kPeerNuisances> along{T(0.0), T(0.0), T(0.0)};
  for (std::size_t row = 0; row < kPeerReadings; ++row) {
    for (std::size_t k = 0; k < kPeerNuisances; ++k) {
      along[k] += scan.nuisance_basis[kPeerNuisances * row + k] * values[stride * row];
    }
  }
  for (std::size_t row = 0; row < kPeerReadings; ++row) {
    for (std::size_t k = 0; k < kPeerNuisances; ++k) {
      values[stride * row] -= scan.nuisance_basis[kPeerNuisances * row + k] * along[k];
    }
  }
}

}  // namespace omni::peers
