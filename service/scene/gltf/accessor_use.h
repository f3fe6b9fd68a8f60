// Which accessors may be read as what: type, and component types by OpenGL's numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "service/scene/gltf/json_reading.h"

namespace omni::scene {

enum Use : unsigned {
  kIndex = 1,
  kPosition = 2,
  kUv = 4,
  kVector = 8,
  kRotation = 16,
  kNormal = 32,
  kColour3 = 64,
  kColour4 = 128
};

struct UseRow {
  Use use;
  const char* type;
  std::size_t components;
  const char* allowed;
};
const UseRow& RowOf(Use use);

struct ComponentRow {
  std::uint64_t type;  // OpenGL's number
  std::size_t bytes;
  unsigned uses;  // integers for positions, coordinates and normals: KHR_mesh_quantization
};
// Of `parent`/componentType. Throws LoadError when it is not allowed for this use.
const ComponentRow& ComponentOf(const Json& parent, const std::string& pointer, Use use);

// Of a type that ComponentOf has returned.
std::size_t ComponentBytes(std::uint64_t type);

}  // namespace omni::scene
