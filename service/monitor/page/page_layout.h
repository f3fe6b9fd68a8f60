// What each binary message to the page holds, field after field without gaps. One list for two: page_messages.cc writes
// the bytes by it, and tests/monitor/contract prints it for those who read them (service/page/src/contract.ts).
// An `Out` is PageBytes, or has its functions:
//   Put(name, value)               a number, or an array of them
//   PutAll(name, lengths, values)  one array: as many values as the product of the fields `lengths` of this message;
//                                  without `lengths` the rest of the message
//   Object(name, put)              fields of their own
//   Each(name, values, put)        the same, so many times as there are values: always as many
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "service/monitor/page/channels.h"
#include "service/monitor/page/page_messages.h"

namespace omni::monitor {

inline std::uint32_t Count(std::size_t size) { return static_cast<std::uint32_t>(size); }
template <std::size_t N>
std::array<float, N> Single(const std::array<double, N>& values) {
  std::array<float, N> singles;
  for (std::size_t i = 0; i < N; ++i) singles[i] = Single(values[i]);
  return singles;
}

class PageBytes {
 public:
  explicit PageBytes(std::size_t reserve) { text_.reserve(reserve); }

  template <class T>
  void Put(const char*, const T& value) {
    static_assert(std::is_trivially_copyable_v<T> && std::endian::native == std::endian::little);
    text_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  template <class T>
  void PutAll(const char*, std::initializer_list<const char*>, std::span<const T> values) {
    text_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  template <class F>
  void Object(const char*, const F& put) {
    put();
  }
  template <class T, std::size_t N, class F>
  void Each(const char*, std::span<const T, N> values, const F& put) {
    for (const T& value : values) put(value);
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

// Of every message.
template <class Out>
void PutHead(Out& out, PageMessage kind) {
  out.Put("magic", kPageMagic);
  out.Put("kind", static_cast<std::uint16_t>(kind));
  out.Put("version", kPageVersion);
}

template <class Out>
void PutLive(Out& out, const LiveFrame& frame) {
  PutHead(out, PageMessage::kLive);
  out.Put("count", Count(frame.times_s.size()));
  out.Put("channels", Count(Channels().size()));
  out.Put("flags", frame.newest.flags);
  out.Put("lost", frame.lost);
  out.Put("t_s", static_cast<double>(frame.newest.t_ns) * 1e-9);
  out.Put("contact_count", std::min(frame.contacts.count, protocol::kMaxSampledContacts));
  out.Put("has_vehicle", frame.vehicle.on);
  out.Each("contacts", std::span(frame.contacts.contacts), [&](const protocol::ContactSample& contact) {
    out.Put("object", contact.object);
    out.Put("material", contact.material);
    out.Put("point", Single(contact.point_base_m));
    out.Put("normal", Single(contact.normal_base));
    out.Put("force", Single(contact.force_base_N));
    out.Put("slip", Single(contact.slip_base_m_s));
    out.Put("normal_N", Single(contact.normal_force_N));
    out.Put("tangential_N", Single(contact.tangential_force_N));
    out.Put("penetration_m", Single(contact.penetration_m));
  });
  out.Object("vehicle", [&] {
    out.Put("sliding", frame.vehicle.sliding);
    out.Put("laps", frame.vehicle.laps);
    out.Put("hits", frame.vehicle.hits);
    out.Put("position", Single(frame.vehicle.position_base_m));
    out.Put("heading", Single(frame.vehicle.heading_rad));
    out.Put("speed_m_s", Single(frame.vehicle.speed_m_s));
    out.Put("lap_s", Single(frame.vehicle.lap_s));
    out.Put("last_lap_s", Single(frame.vehicle.last_lap_s));
    out.Put("best_lap_s", Single(frame.vehicle.best_lap_s));
  });
  out.Each("inputs", std::span(frame.inputs.components), [&](const protocol::InputValue& input) {
    out.Put("value", input.value);
    out.Put("presses", input.press_count);
    out.Put("releases", input.release_count);
  });
  out.Object("aim", [&] {
    out.Put("present", frame.aim.present);
    out.Put("tip", Single(frame.aim.tip_base_m));
    out.Put("axis", Single(frame.aim.axis_base));
  });
  out.Put("zero", std::uint32_t{0});  // the times are aligned
  out.PutAll("times_s", {"count"}, std::span(frame.times_s));
  out.PutAll("samples", {"count", "channels"}, std::span(frame.rows));
}

template <class Out>
void PutShape(Out& out, std::uint32_t scene, std::uint32_t part, const DrawnShape& shape) {
  const bool coloured = shape.colours.size() == shape.positions.size() && !shape.colours.empty();
  PutHead(out, PageMessage::kShape);
  out.Put("scene", scene);
  out.Put("part", part);
  out.Put("vertex_count", Count(shape.positions.size()));
  out.Put("triangle_count", Count(shape.triangles.size()));
  out.Put("coloured", std::uint32_t{coloured});  // 0 or 1
  out.Put("colour", shape.colour);
  out.Put("roughness", shape.roughness);
  out.PutAll("positions", {"vertex_count"}, std::span(shape.positions));
  out.PutAll("normals", {"vertex_count"}, std::span(shape.normals));
  out.PutAll("triangles", {"triangle_count"}, std::span(shape.triangles));
  out.PutAll("colours", {"coloured", "vertex_count"},
             std::span(shape.colours).first(coloured ? shape.colours.size() : 0));
}

template <class Out>
void PutSurface(Out& out, std::uint32_t scene, std::uint32_t object, const protocol::SurfaceFrame& frame,
                std::span<const protocol::SurfacePoint> vertices,
                std::span<const protocol::SurfaceTriangle> triangles) {
  PutHead(out, PageMessage::kSurface);
  out.Put("scene", scene);
  out.Put("object", object);
  out.Put("vertex_count", Count(vertices.size()));
  out.Put("triangle_count", Count(triangles.size()));
  out.Put("rotation", Single(frame.rotation_wxyz));
  out.Put("translation", Single(frame.translation_m));
  out.Put("largest_displacement_m", Single(frame.largest_displacement_m));
  out.PutAll("positions", {"vertex_count"}, vertices);
  out.PutAll("triangles", {"triangle_count"}, triangles);
}

template <class Out>
void PutFile(Out& out, std::uint32_t number, std::string_view name, std::string_view bytes) {
  PutHead(out, PageMessage::kFile);
  out.Put("number", number);
  out.Put("name_bytes", Count(name.size()));
  out.PutAll("name", {"name_bytes"}, std::span(name));
  out.PutAll("bytes", {}, std::span(bytes));
}

// From the page to the server: ReadDroppedFile.
template <class Out>
void PutDrop(Out& out, std::string_view name, std::string_view bytes) {
  PutHead(out, PageMessage::kDrop);
  out.Put("name_bytes", Count(name.size()));
  out.PutAll("name", {"name_bytes"}, std::span(name));
  out.PutAll("bytes", {}, std::span(bytes));
}

}  // namespace omni::monitor
