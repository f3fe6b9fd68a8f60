// Nested dissection by coordinates [George 1973]: an order of elimination that keeps the factor of a finite-element
// matrix small. Set-up only.
#pragma once

#include <cstdint>
#include <vector>

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

// Order in which to eliminate `nodes`; `neighbours[n]` of every node n.
std::vector<std::uint32_t> DissectionOrder(const std::vector<Vec3>& position, std::vector<std::uint32_t> nodes,
                                           const std::vector<std::vector<std::uint32_t>>& neighbours);

}  // namespace omni::haptics
