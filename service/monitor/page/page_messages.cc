#include "service/monitor/page/page_messages.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

#include "service/monitor/page/channels.h"

namespace omni::monitor {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kMaxNameBytes = 255;

class Writer {
 public:
  explicit Writer(PageMessage kind, std::size_t bytes) {
    text_.reserve(bytes);
    Put(kPageMagic);
    Put(kind);
    Put(kPageVersion);
  }

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void Put(const T& value) { text_.append(reinterpret_cast<const char*>(&value), sizeof(value)); }
  template <class T>
  void PutAll(std::span<const T> values) {
    text_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  void PutSingle(double value) { Put(static_cast<float>(value)); }
  void PutSingles(std::span<const double> values) {
    for (const double value : values) PutSingle(value);
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

std::uint32_t Count(std::size_t size) { return static_cast<std::uint32_t>(size); }

void PutContact(const protocol::ContactSample& contact, Writer& out) {
  out.Put(contact.object);
  out.Put(contact.material);
  for (const auto* v : {&contact.point_base_m, &contact.normal_base, &contact.force_base_N, &contact.slip_base_m_s}) {
    out.PutSingles(*v);
  }
  out.PutSingle(contact.normal_force_N);
  out.PutSingle(contact.tangential_force_N);
  out.PutSingle(contact.penetration_m);
}

void PutVehicle(const protocol::VehicleSnapshot& vehicle, Writer& out) {
  out.Put(vehicle.sliding);
  out.Put(vehicle.laps);
  out.Put(vehicle.hits);
  out.PutSingles(vehicle.position_base_m);
  for (const double value :
       {vehicle.heading_rad, vehicle.speed_m_s, vehicle.lap_s, vehicle.last_lap_s, vehicle.best_lap_s}) {
    out.PutSingle(value);
  }
}

}  // namespace

std::string LiveMessage(const LiveFrame& frame) {
  Writer out(PageMessage::kLive, 512 + 8 * frame.times_s.size() + 4 * frame.rows.size());
  out.Put(Count(frame.times_s.size()));
  out.Put(Count(Channels().size()));
  out.Put(frame.newest.flags);
  out.Put(frame.lost);
  out.Put(static_cast<double>(frame.newest.t_ns) * 1e-9);
  out.Put(std::min(frame.contacts.count, protocol::kMaxSampledContacts));
  out.Put(frame.vehicle.on);
  for (const protocol::ContactSample& contact : frame.contacts.contacts) PutContact(contact, out);
  PutVehicle(frame.vehicle, out);
  for (const protocol::InputValue& input : frame.inputs.components) {
    out.Put(input.value);
    out.Put(input.press_count);
    out.Put(input.release_count);
  }
  out.Put(frame.aim.present);
  out.PutSingles(frame.aim.tip_base_m);
  out.PutSingles(frame.aim.axis_base);
  out.Put(std::uint32_t{0});  // the times are aligned
  out.PutAll(std::span(frame.times_s));
  out.PutAll(std::span(frame.rows));
  return out.Take();
}

std::string ShapeMessage(std::uint32_t scene, std::uint32_t part, const DrawnShape& shape) {
  Writer out(PageMessage::kShape, 64 + 28 * shape.positions.size() + 12 * shape.triangles.size());
  const bool coloured = shape.colours.size() == shape.positions.size() && !shape.colours.empty();
  out.Put(scene);
  out.Put(part);
  out.Put(Count(shape.positions.size()));
  out.Put(Count(shape.triangles.size()));
  out.Put(std::uint32_t{coloured});
  out.Put(shape.colour);
  out.Put(shape.roughness);
  out.PutAll(std::span(shape.positions));
  out.PutAll(std::span(shape.normals));
  out.PutAll(std::span(shape.triangles));
  if (coloured) out.PutAll(std::span(shape.colours));
  return out.Take();
}

std::string SurfaceMessage(std::uint32_t scene, std::uint32_t object, const protocol::SurfaceFrame& frame,
                           std::span<const protocol::SurfacePoint> vertices,
                           std::span<const protocol::SurfaceTriangle> triangles) {
  Writer out(PageMessage::kSurface, 64 + vertices.size_bytes() + triangles.size_bytes());
  out.Put(scene);
  out.Put(object);
  out.Put(Count(vertices.size()));
  out.Put(Count(triangles.size()));
  out.PutSingles(frame.rotation_wxyz);
  out.PutSingles(frame.translation_m);
  out.PutSingle(frame.largest_displacement_m);
  out.PutAll(vertices);
  out.PutAll(triangles);
  return out.Take();
}

std::string FileMessage(std::uint32_t number, std::string_view name, std::string_view bytes) {
  Writer out(PageMessage::kFile, 16 + name.size() + bytes.size());
  out.Put(number);
  out.Put(Count(name.size()));
  out.PutAll(std::span(name));
  out.PutAll(std::span(bytes));
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
