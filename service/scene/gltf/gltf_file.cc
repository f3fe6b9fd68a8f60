#include "service/scene/gltf/gltf_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>

#include "service/scene/gltf/file_bytes.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

// glTF 2.0, "GLB File Format Specification": magic, version, length, then chunks of {length, type, data}, little
// endian.
constexpr std::uint32_t kMagic = 0x46546C67;     // "glTF"
constexpr std::uint32_t kBinChunk = 0x004E4942;  // "BIN\0"

constexpr std::size_t kMaxFilesBeside = 100;  // open at a time, of the thousand that a process may have

// Extensions that may be required: read here, or without influence on where surfaces are.
constexpr std::string_view kKnownExtensions[] = {
    "ADOBE_materials_thin_transparency",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_physics_rigid_bodies",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MPEG_haptic_material",
    "MPEG_material_haptic",
    "MSFT_texture_dds",
    "OMNI_haptic_material",
};
constexpr std::string_view kMaterialExtensions = "KHR_materials_";
// Others of these concern drawing, whatever they are.
constexpr std::string_view kDrawingExtensions[] = {"KHR_texture_", "KHR_lights_",    "EXT_texture_",
                                                   "EXT_lights_",  "EXT_materials_", "MSFT_texture_"};

void CheckRequiredExtensions(const Json& root, const std::string& path, LoadReport& report) {
  const Json* required = FindArray(root, "", "extensionsRequired");
  std::string unknown;  // that concern drawing
  for (std::size_t i = 0; required && i < required->elements().size(); ++i) {
    const Json& element = required->elements()[i];
    const std::string pointer = JoinPointer("/extensionsRequired", i);
    if (!element.is_text()) throw LoadError(pointer, "is " + ValueText(element) + ", must be a string");
    const std::string_view name = element.text();
    const auto starts = [name](std::string_view prefix) { return name.starts_with(prefix); };
    if (starts(kMaterialExtensions) || std::ranges::find(kKnownExtensions, name) != std::end(kKnownExtensions))
      continue;
    if (std::ranges::none_of(kDrawingExtensions, starts)) {
      throw LoadError(pointer, "is " + ValueText(element) +
                                   ", which cannot be read, and shapes may depend on it; export without this extension "
                                   "(if it only changes how the model looks, take it out of extensionsRequired)");
    }
    if (unknown.empty()) unknown = pointer + ": is " + ValueText(element) + ", which is not known; it concerns drawing";
  }
  if (!unknown.empty()) report.warnings.push_back(Printable(path + ": " + unknown));
}

// minVersion: of what a reader must know.
void CheckVersion(const Json& root) {
  const Json* asset = FindObject(root, "", "asset");
  if (!asset) throw LoadError("/asset", "is missing; this is not a glTF 2.0 document");
  const std::string version = FindString(*asset, "/asset", "version", "");
  if (!version.starts_with("2.")) {
    throw LoadError("/asset/version",
                    "is \"" + version.substr(0, 20) + "\", only glTF 2.x can be read; export it as 2.0");
  }
  const std::string least = FindString(*asset, "/asset", "minVersion", "2.0");
  int major = 0, minor = 0;
  const char* const end = least.data() + least.size();
  const auto [point, error] = std::from_chars(least.data(), end, major);
  const bool read = error == std::errc() && point != end && *point == '.' &&
                    std::from_chars(point + 1, end, minor).ptr == end && point + 1 != end;
  if (!read || major < 0 || minor < 0)
    throw LoadError("/asset/minVersion", "is \"" + least.substr(0, 20) + "\", must be a version such as 2.0");
  if (major > 2 || (major == 2 && minor > 0)) {
    throw LoadError("/asset/minVersion", "is \"" + least.substr(0, 20) +
                                             "\": it needs a reader of that version, and glTF 2.0 is what can be read; "
                                             "export it as 2.0");
  }
}

std::uint32_t LittleEndian(const unsigned char* bytes) {
  return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8 |
         static_cast<std::uint32_t>(bytes[2]) << 16 | static_cast<std::uint32_t>(bytes[3]) << 24;
}

}  // namespace

void GltfFile::Open(const std::string& path, const LoadOptions& options, LoadReport& report) {
  path_ = path;
  max_file_bytes_ = options.max_file_bytes;
  in_memory_ = options.memory >= 0;
  beside_ = options.beside;
  watch_ = options.watch;
  file_.WatchBy(watch_);
  if (in_memory_) {
    file_.OpenDescriptor(options.memory, max_file_bytes_);
  } else {
    file_.Open(path, max_file_bytes_);
  }
  file_.AddTo(&digest_);
  report.file_bytes = file_.size();
  document_ = ParseJson(ReadJsonText(report));
  CheckVersion(root());
  CheckRequiredExtensions(root(), path_, report);
}

std::string GltfFile::ReadJsonText(LoadReport& report) {
  if (file_.size() == 0) throw LoadError("", "is empty");
  std::array<unsigned char, 20> header{};
  const auto head = static_cast<std::size_t>(std::min<std::uint64_t>(header.size(), file_.size()));
  file_.Read(0, header.data(), head);
  std::uint64_t json_offset = 0, json_length = file_.size();
  const bool binary = head >= 4 && LittleEndian(header.data()) == kMagic;
  if (binary) {
    if (head < 20) throw LoadError("", "is cut off inside the binary glTF header; copy or export it again");
    const std::uint32_t version = LittleEndian(&header[4]);
    const std::uint64_t length = LittleEndian(&header[8]);
    if (version != 2) throw LoadError("", "is binary glTF version " + std::to_string(version) + ", only 2 can be read");
    if (length > file_.size()) {
      throw LoadError("", "its header says " + std::to_string(length) + " bytes, the file has " +
                              std::to_string(file_.size()) + "; it is truncated, copy or export it again");
    }
    if (length < file_.size())
      report.warnings.push_back(path_ + ": bytes after the end of the binary glTF are ignored");
    json_offset = 20;
    json_length = LittleEndian(&header[12]);
    if (LittleEndian(&header[16]) != kJsonChunk) throw LoadError("", "first chunk of the binary glTF is not JSON");
    if (!(json_length <= length - 20)) {
      throw LoadError("", "its JSON chunk says " + std::to_string(json_length) + " bytes, more than the file holds");
    }
    const std::uint64_t chunk = 20 + (json_length + 3) / 4 * 4;
    if (chunk + 8 <= length) {
      file_.Read(chunk, header.data(), 8);
      has_bin_ = LittleEndian(&header[4]) == kBinChunk;
      bin_offset_ = chunk + 8;
      bin_length_ = LittleEndian(header.data());
      if (has_bin_ && !(bin_length_ <= length - bin_offset_)) {
        throw LoadError("", "its BIN chunk says " + std::to_string(bin_length_) + " bytes, the file holds " +
                                std::to_string(length - bin_offset_) + "; it is truncated, copy or export it again");
      }
    }
  }
  if (json_length > kSceneJson.bytes) {
    throw LoadError("", "has " + std::to_string(json_length) + " bytes of JSON, the limit is " +
                            std::to_string(kSceneJson.bytes) + "; move embedded buffers into a .bin or use .glb");
  }
  json_bytes_ = json_length;
  std::string text(static_cast<std::size_t>(json_length), '\0');
  file_.Read(json_offset, text.data(), text.size());
  if (!binary && text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // byte order mark
  if (!binary && text.substr(0, text.find_first_not_of(" \t\r\n") + 1).find('{') == std::string::npos) {
    throw LoadError("", "is neither binary glTF (\"glTF\" at its start) nor JSON text; export it as .glb or .gltf");
  }
  return text;
}

std::uint64_t GltfFile::bytes_read() const {
  std::uint64_t sum = file_.bytes_read();
  for (const FileBytes& file : external_) sum += file.bytes_read();
  return sum;
}

std::uint64_t GltfFile::stored_bytes() const {
  std::uint64_t sum = file_.size();
  for (const FileBytes& file : external_) sum += file.size();
  return sum;
}

FileBytes& GltfFile::OpenBeside(const std::string& uri, const std::string& pointer) {
  if (in_memory_ && beside_ == nullptr) {
    throw LoadError(pointer,
                    "names \"" + uri.substr(0, 60) +
                        "\", but a document in memory has no files beside it: export as .glb, or with data URIs");
  }
  if (external_.size() == kMaxFilesBeside) {
    throw LoadError(pointer, "names more than " + std::to_string(kMaxFilesBeside) +
                                 " files beside the document, which is the limit; export as .glb");
  }
  const std::string name = PathBeneath(uri, pointer);
  const std::filesystem::path folder = std::filesystem::path(path_).parent_path(), file = folder / name;
  FileBytes& bytes = external_.emplace_back();
  bytes.AddTo(&digest_);
  bytes.WatchBy(watch_);
  try {
    FilesInFolder own(folder.string());
    bytes.TakeDescriptor((in_memory_ ? *beside_ : own).OpenBeside(name), max_file_bytes_);
  } catch (const LoadError& error) {
    throw LoadError(pointer, file.string() + " " + error.what());
  }
  return bytes;
}

void GltfFile::OpenExternal(const std::string& uri, const std::string& pointer, Buffer& buffer) {
  FileBytes& bytes = OpenBeside(uri, pointer);
  if (bytes.size() < buffer.length) {
    throw LoadError(pointer, "its file has " + std::to_string(bytes.size()) + " bytes, byteLength says " +
                                 std::to_string(buffer.length) + "; it is truncated or belongs to another model");
  }
  buffer.file = &bytes;
}

GltfFile::Buffer& GltfFile::OpenBuffer(std::uint32_t index) {
  if (const auto found = buffers_.find(index); found != buffers_.end()) return found->second;
  const std::string pointer = JoinPointer("/buffers", index);
  const Json& json = ElementOf(root(), "buffers", index);
  Buffer buffer;
  buffer.length = ReadInteger(json, pointer, "byteLength", max_file_bytes_, std::nullopt);
  const std::string uri = FindString(json, pointer, "uri", "");
  if (uri.empty()) {
    if (index != 0 || !has_bin_) {
      throw LoadError(pointer, "has no data: no uri and no BIN chunk that belongs to it; export the file again");
    }
    if (buffer.length > bin_length_) {
      throw LoadError(
          JoinPointer(pointer, "byteLength"),
          "is " + std::to_string(buffer.length) + ", the BIN chunk has " + std::to_string(bin_length_) + " bytes");
    }
    buffer.file = &file_;
    buffer.offset = bin_offset_;
  } else if (uri.starts_with("data:")) {
    buffer.embedded = DecodeDataUri(uri, JoinPointer(pointer, "uri"));
    if (buffer.embedded.size() < buffer.length) {
      throw LoadError(JoinPointer(pointer, "uri"), "holds " + std::to_string(buffer.embedded.size()) +
                                                       " bytes, byteLength says " + std::to_string(buffer.length));
    }
  } else {
    OpenExternal(uri, JoinPointer(pointer, "uri"), buffer);
  }
  return buffers_.emplace(index, std::move(buffer)).first->second;
}

bool GltfFile::HasBuffer(std::uint32_t index) {
  try {
    OpenBuffer(index);
    return true;
  } catch (const LoadError&) {
    return false;
  }
}

std::vector<unsigned char> GltfFile::ReadImage(std::uint32_t index, std::uint64_t max_bytes) {
  const std::string pointer = JoinPointer("/images", index);
  const Json& json = ElementOf(root(), "images", index);
  const auto check = [&](std::uint64_t bytes) {
    if (bytes > max_bytes) {
      throw LoadError(pointer, "has " + std::to_string(bytes) + " bytes, the limit is " + std::to_string(max_bytes));
    }
  };
  std::vector<unsigned char> stored;
  if (const auto view = ReadIndex(json, pointer, "bufferView", CountOf(root(), "bufferViews"))) {
    const Json& view_json = ElementOf(root(), "bufferViews", *view);
    const std::string place = JoinPointer("/bufferViews", *view);
    const auto buffer = ReadIndex(view_json, place, "buffer", CountOf(root(), "buffers"));
    if (!buffer) throw LoadError(JoinPointer(place, "buffer"), "is missing");
    const std::uint64_t offset = ReadInteger(view_json, place, "byteOffset", 1ull << 40, 0);
    const std::uint64_t length = ReadInteger(view_json, place, "byteLength", 1ull << 40, std::nullopt);
    check(length);
    unsigned char last = 0;  // is it there? Checked before memory is allocated
    if (length > 0) ReadBuffer(*buffer, offset + length - 1, &last, 1);
    stored.resize(static_cast<std::size_t>(length));
    ReadBuffer(*buffer, offset, stored.data(), stored.size());
    return stored;
  }
  const std::string uri = FindString(json, pointer, "uri", "");
  if (uri.empty()) throw LoadError(pointer, "has neither bufferView nor uri");
  if (uri.starts_with("data:")) {
    stored = DecodeDataUri(uri, JoinPointer(pointer, "uri"));
    check(stored.size());
    return stored;
  }
  FileBytes& bytes = OpenBeside(uri, JoinPointer(pointer, "uri"));
  check(bytes.size());
  stored.resize(static_cast<std::size_t>(bytes.size()));
  bytes.Read(0, stored.data(), stored.size());
  return stored;
}

void GltfFile::ReadBuffer(std::uint32_t index, std::uint64_t offset, void* to, std::size_t count) {
  Buffer& buffer = OpenBuffer(index);
  if (!(offset <= buffer.length && count <= buffer.length - offset)) {
    throw LoadError(JoinPointer("/buffers", index), "has " + std::to_string(buffer.length) + " bytes, but " +
                                                        std::to_string(count) + " bytes at " + std::to_string(offset) +
                                                        " are needed; byteOffset, byteStride or count is wrong");
  }
  if (count == 0) return;
  if (buffer.file) {
    buffer.file->Read(buffer.offset + offset, to, count);
  } else {
    std::memcpy(to, buffer.embedded.data() + offset, count);
  }
}

}  // namespace omni::scene
