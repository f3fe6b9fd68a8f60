// A document that an application gave, as memory that nobody can change any more: what the service is handed.
#pragma once

#include <cstddef>
#include <cstdint>

#include "service/protocol/unique_fd.h"

namespace omni::layer {

// A copy of `bytes` bytes, sealed WRITE | SHRINK | GROW | SEAL. Empty: there is no memory, or no descriptor, for it.
protocol::UniqueFd SealedDocument(const std::uint8_t* content, std::size_t bytes) noexcept;

}  // namespace omni::layer
