// The pen's own render model: layer/models/pen.glb, embedded at build, and how its parts move. The model's frame is the
// tool frame T: origin at the tip, -z out of it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "layer/src/entry/omni_openxr_compat.h"
#include "service/protocol/state_memory.h"

namespace omni::layer {

struct PenModelFile {
  std::span<const std::uint8_t> bytes;
  XrUuidEXT id;  // of these bytes: another file has another one
};
const PenModelFile& EmbeddedPenModel();

// A node of the file that inputs move: by travel_m where one of them is 1.
struct PenPart {
  const char* node;
  XrVector3f travel_m;
  std::array<protocol::InputIndex, 3> inputs;
};
inline constexpr std::array kPenParts{
    PenPart{"tip",
            {0, 0, 0.001f},
            {protocol::InputIndex::kTipForce, protocol::InputIndex::kTipForce, protocol::InputIndex::kTipForce}},
    PenPart{"button",
            {0, -0.0008f, 0},
            {protocol::InputIndex::kSecondary, protocol::InputIndex::kMenu, protocol::InputIndex::kSqueeze}},
};

XrRenderModelNodeStateEXT StateOf(const PenPart& part, const protocol::InputSnapshot& inputs) noexcept;

}  // namespace omni::layer
