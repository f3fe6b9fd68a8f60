#include "service/monitor/page/page_messages.h"

#include <cstring>

#include "service/monitor/page/page_layout.h"

namespace omni::monitor {
namespace {

constexpr std::size_t kMaxNameBytes = 255;

}  // namespace

std::string LiveMessage(const LiveFrame& frame) {
  PageBytes out(512 + 8 * frame.times_s.size() + 4 * frame.rows.size());
  PutLive(out, frame);
  return out.Take();
}

std::string ShapeMessage(std::uint32_t scene, std::uint32_t part, const DrawnShape& shape) {
  PageBytes out(64 + 28 * shape.positions.size() + 12 * shape.triangles.size());
  PutShape(out, scene, part, shape);
  return out.Take();
}

std::string SurfaceMessage(std::uint32_t scene, std::uint32_t object, const protocol::SurfaceFrame& frame,
                           std::span<const protocol::SurfacePoint> vertices,
                           std::span<const protocol::SurfaceTriangle> triangles) {
  PageBytes out(64 + vertices.size_bytes() + triangles.size_bytes());
  PutSurface(out, scene, object, frame, vertices, triangles);
  return out.Take();
}

std::string FileMessage(std::uint32_t number, std::string_view name, std::string_view bytes) {
  PageBytes out(16 + name.size() + bytes.size());
  PutFile(out, number, name, bytes);
  return out.Take();
}

DroppedFile ReadDroppedFile(std::string_view message) {
  struct Head {
    std::uint32_t magic;
    PageMessage kind;
    std::uint16_t version;
    std::uint32_t name_bytes;
  } head;
  static_assert(sizeof(head) == 12);
  DroppedFile file;
  file.problem = "a binary message is not a dropped file; reload the page";
  if (message.size() < sizeof(head)) return file;
  std::memcpy(&head, message.data(), sizeof(head));
  if (head.magic != kPageMagic || head.kind != PageMessage::kDrop || head.version != kPageVersion) return file;
  message.remove_prefix(sizeof(head));
  if (head.name_bytes > kMaxNameBytes || head.name_bytes > message.size()) return file;
  file.name = message.substr(0, head.name_bytes);
  file.bytes = message.substr(head.name_bytes);
  const bool binary_gltf = file.bytes.size() >= 12 && file.bytes.substr(0, 4) == "glTF";
  file.problem = binary_gltf ? "" : "this is no binary glTF file (.glb); save the model as .glb and drop that";
  return file;
}

}  // namespace omni::monitor
