// Binary messages to the page: layouts of docs/protocol/page.md, little endian. service/page/src/decode.ts reads them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "service/protocol/hand_aim.h"
#include "service/protocol/state_memory.h"
#include "service/protocol/surfaces/surface_memory.h"

namespace omni::monitor {

inline constexpr std::uint32_t kPageMagic = 0x47504D4F;  // "OMPG"
inline constexpr std::uint16_t kPageVersion = 1;         // of text and binary messages

enum class PageMessage : std::uint16_t { kLive = 1, kShape = 2, kSurface = 3, kFile = 4, kDrop = 16 };

// The newest of everything, and each tick since the last message.
struct LiveFrame {
  std::uint32_t lost = 0;  // ticks that were overwritten before they were read
  protocol::ToolSample newest;
  protocol::ContactSnapshot contacts;
  protocol::VehicleSnapshot vehicle;
  protocol::InputSnapshot inputs;
  protocol::HandAim aim;  // present: a page leads the hand
  // Of every tick: its time, and a row of page/channels.h.
  std::vector<double> times_s;
  std::vector<float> rows;
};
std::string LiveMessage(const LiveFrame& frame);

// A part of a scene as it looks, base frame.
struct DrawnShape {
  std::array<float, 3> colour{0.7F, 0.7F, 0.7F};  // linear RGB
  float roughness = 0.7F;
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::array<std::uint8_t, 4>> colours;  // linear RGB x 255; empty: `colour` everywhere
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
std::string ShapeMessage(std::uint32_t scene, std::uint32_t part, const DrawnShape& shape);

// Empty vertices: only the pose has changed. Empty triangles: as before.
std::string SurfaceMessage(std::uint32_t scene, std::uint32_t object, const protocol::SurfaceFrame& frame,
                           std::span<const protocol::SurfacePoint> vertices,
                           std::span<const protocol::SurfaceTriangle> triangles);

std::string FileMessage(std::uint32_t number, std::string_view name, std::string_view bytes);

// A file that was dropped onto the page. The error is for the person.
struct DroppedFile {
  std::string_view name, bytes;  // views into the message
  std::string problem;           // empty: none
};
DroppedFile ReadDroppedFile(std::string_view message);

}  // namespace omni::monitor
