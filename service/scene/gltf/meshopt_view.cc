#include "service/scene/gltf/meshopt_view.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <meshoptimizer.h>

namespace omni::scene {
namespace {

using Mode = MeshoptView::Mode;
using Filter = MeshoptView::Filter;

constexpr const char* kExtensions[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
constexpr std::uint64_t kMaxCount = 1ull << 32;

template <class Value>
struct Word {
  std::string_view name;
  Value value;
};
constexpr std::array kModes = {Word<Mode>{"ATTRIBUTES", Mode::kAttributes}, Word<Mode>{"TRIANGLES", Mode::kTriangles},
                               Word<Mode>{"INDICES", Mode::kIndices}};
constexpr std::array kFilters = {Word<Filter>{"NONE", Filter::kNone}, Word<Filter>{"OCTAHEDRAL", Filter::kOctahedral},
                                 Word<Filter>{"QUATERNION", Filter::kQuaternion},
                                 Word<Filter>{"EXPONENTIAL", Filter::kExponential}};

template <class Words>
auto WordOf(const Words& words, const Json& json, const std::string& pointer, const char* key, const char* fallback) {
  const std::string name = FindString(json, pointer, key, fallback);
  for (const auto& word : words) {
    if (word.name == name) return word.value;
  }
  std::string known;
  for (const auto& word : words) known += (known.empty() ? "" : ", ") + std::string(word.name);
  throw LoadError(JoinPointer(pointer, key), "is \"" + name.substr(0, 40) + "\", and what can be read is " + known +
                                                 "; export without mesh compression (gltfpack: no -c)");
}

const Json* ExtensionOf(const Json& view, const char* name) {
  const Json* extensions = FindMember(view, "extensions");
  return extensions ? FindMember(*extensions, name) : nullptr;
}

}  // namespace

std::optional<MeshoptView> MeshoptOf(const Json& root, std::uint32_t number) {
  const Json& json = ElementOf(root, "bufferViews", number);
  const std::string view_pointer = JoinPointer("/bufferViews", number);
  const Json* extensions = FindObject(json, view_pointer, "extensions");
  const std::string place = JoinPointer(view_pointer, "extensions");
  for (const char* name : kExtensions) {
    const Json* compressed = extensions ? FindObject(*extensions, place, name) : nullptr;
    if (!compressed) continue;
    MeshoptView view;
    view.pointer = JoinPointer(place, name);
    const auto buffer = ReadIndex(*compressed, view.pointer, "buffer", CountOf(root, "buffers"));
    if (!buffer) throw LoadError(JoinPointer(view.pointer, "buffer"), "is missing");
    view.buffer = *buffer;
    view.offset = ReadInteger(*compressed, view.pointer, "byteOffset", kMaxViewOffset, 0);
    view.length = ReadInteger(*compressed, view.pointer, "byteLength", kMaxViewOffset, std::nullopt);
    view.stride = static_cast<std::size_t>(ReadInteger(*compressed, view.pointer, "byteStride", 256, std::nullopt));
    view.count = ReadInteger(*compressed, view.pointer, "count", kMaxCount, std::nullopt);
    view.mode = WordOf(kModes, *compressed, view.pointer, "mode", "");
    view.filter = WordOf(kFilters, *compressed, view.pointer, "filter", "NONE");
    const bool attributes = view.mode == Mode::kAttributes;
    const std::size_t stride = view.stride;
    const bool strides = attributes ? stride > 0 && stride % 4 == 0 : stride == 2 || stride == 4;
    const bool filtered = view.filter == Filter::kNone || view.filter == Filter::kExponential ||
                          (view.filter == Filter::kOctahedral && (stride == 4 || stride == 8)) ||
                          (view.filter == Filter::kQuaternion && stride == 8);
    if (!strides || !filtered || (!attributes && view.filter != Filter::kNone)) {
      throw LoadError(
          JoinPointer(view.pointer, "byteStride"),
          "is " + std::to_string(stride) + ", which this mode and filter do not allow; export the file again");
    }
    if (view.mode == Mode::kTriangles && view.count % 3 != 0) {
      throw LoadError(JoinPointer(view.pointer, "count"),
                      "is " + std::to_string(view.count) + ", must be a multiple of 3 for triangles");
    }
    return view;
  }
  return std::nullopt;
}

// The decoder is safe for any bytes; what it makes of them is checked like data that was not compressed.
void DecodeMeshopt(const MeshoptView& view, std::span<const unsigned char> compressed,
                   std::span<unsigned char> decoded) {
  const auto count = static_cast<std::size_t>(view.count);
  if (count == 0) return;
  using Decode = int(void*, std::size_t, std::size_t, const unsigned char*, std::size_t);
  Decode* decode = meshopt_decodeVertexBuffer;
  if (view.mode == Mode::kTriangles) decode = meshopt_decodeIndexBuffer;
  if (view.mode == Mode::kIndices) decode = meshopt_decodeIndexSequence;
  if (decoded.size() != view.decoded_bytes() ||
      decode(decoded.data(), count, view.stride, compressed.data(), compressed.size()) != 0) {
    throw LoadError(view.pointer,
                    "its data cannot be decoded: it is damaged, or of a newer codec; export again, without mesh "
                    "compression if that does not help (gltfpack: no -c)");
  }
  if (view.filter == Filter::kOctahedral) meshopt_decodeFilterOct(decoded.data(), count, view.stride);
  if (view.filter == Filter::kQuaternion) meshopt_decodeFilterQuat(decoded.data(), count, view.stride);
  if (view.filter == Filter::kExponential) meshopt_decodeFilterExp(decoded.data(), count, view.stride);
}

std::uint64_t MeshoptBytes(const Json& root) {
  std::uint64_t bytes = 0;
  const Json* views = FindArray(root, "", "bufferViews");
  for (const Json& view : views ? views->elements() : std::span<const Json>()) {
    for (const char* name : kExtensions) {
      const Json* compressed = ExtensionOf(view, name);
      if (!compressed) continue;
      const auto number = [&](const char* key, std::uint64_t most) {
        const Json* found = FindMember(*compressed, key);
        return std::min(found ? found->whole().value_or(0) : 0, most);
      };
      bytes += number("byteLength", kMaxViewOffset) + number("count", kMaxCount) * number("byteStride", 256);
      bytes = std::min(bytes, kMaxViewOffset);
    }
  }
  return bytes;
}

}  // namespace omni::scene
