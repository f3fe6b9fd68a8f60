#include "service/scene/tags/haptic_texture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include <stb/stb_image.h>

#include "service/base/free_memory.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/tags/relief_image.h"

namespace omni::scene {
namespace {

// Of a list of textures the first of these that is there is taken; entries beyond the limit are ignored.
constexpr const char* kTypes[] = {"High_Resolution", "Low_Resolution", "Other"};
constexpr std::size_t kMaxEntries = 16;
// Different uses of textures: they are searched one by one.
constexpr std::uint64_t kMostReliefPixels = std::uint64_t{haptics::kMaxReliefSide} * haptics::kMaxReliefSide;
constexpr std::size_t kMaxMade = 4 * haptics::kMaxTextures;

// u' = T R S u, with R turning clockwise on the image   [KHR_texture_transform]
std::array<double, 6> TransformOf(const Json& info, const std::string& pointer, std::uint64_t& uv_set) {
  std::array<double, 6> affine{1, 0, 0, 0, 1, 0};
  const Json* extensions = FindObject(info, pointer, "extensions");
  const Json* transform =
      extensions ? FindObject(*extensions, JoinPointer(pointer, "extensions"), "KHR_texture_transform") : nullptr;
  if (!transform) return affine;
  const std::string place = JoinPointer(JoinPointer(pointer, "extensions"), "KHR_texture_transform");
  const auto offset = ReadNumberArray(*transform, place, "offset", 2),
             scale = ReadNumberArray(*transform, place, "scale", 2);
  const Json* angle = FindMember(*transform, "rotation");
  if (angle && !(std::abs(angle->number()) <= 1e6))
    throw LoadError(JoinPointer(place, "rotation"), "is " + ValueText(*angle) + ", must be an angle in radians");
  const double turn = angle ? angle->number() : 0;
  const double sx = scale.empty() ? 1 : scale[0], sy = scale.empty() ? 1 : scale[1];
  affine = {std::cos(turn) * sx,  std::sin(turn) * sy, offset.empty() ? 0 : offset[0],
            -std::sin(turn) * sx, std::cos(turn) * sy, offset.empty() ? 0 : offset[1]};
  for (const double x : affine) {
    if (!(std::abs(x) <= 1e6)) throw LoadError(place, "scales or moves by more than a million");
  }
  uv_set = ReadInteger(*transform, place, "texCoord", 1000, uv_set);
  return affine;
}

haptics::Wrap WrapOf(const Json& sampler, const std::string& pointer, const char* key) {
  switch (ReadInteger(sampler, pointer, key, 1 << 16, 10497)) {
    case 33071:
      return haptics::Wrap::kClamp;
    case 33648:
      return haptics::Wrap::kMirror;
    case 10497:
      return haptics::Wrap::kRepeat;
    default:
      throw LoadError(JoinPointer(pointer, key), "must be 33071 (clamp), 33648 (mirror) or 10497 (repeat)");
  }
}

TextureUse UseOf(const Json& root, const Json& info, const std::string& pointer) {
  TextureUse use;
  use.pointer = pointer;
  const auto texture = ReadIndex(info, pointer, "index", CountOf(root, "textures"));
  if (!texture) throw LoadError(JoinPointer(pointer, "index"), "is missing");
  std::uint64_t uv_set = ReadInteger(info, pointer, "texCoord", 1000, 0);
  use.to_image = TransformOf(info, pointer, uv_set);
  if (uv_set >= haptics::kMaxUvSets) {
    throw LoadError(JoinPointer(pointer, "texCoord"),
                    "is " + std::to_string(uv_set) + ", only TEXCOORD_0 and _1 are read");
  }
  use.uv_set = static_cast<std::uint32_t>(uv_set);
  const Json& json = ElementOf(root, "textures", *texture);
  const std::string place = JoinPointer("/textures", *texture);
  const auto source = ReadIndex(json, place, "source", CountOf(root, "images"));
  if (!source) throw LoadError(place, "has no source that is PNG or JPEG");
  use.image = *source;
  if (const auto sampler = ReadIndex(json, place, "sampler", CountOf(root, "samplers"))) {
    const Json& wraps = ElementOf(root, "samplers", *sampler);
    use.wrap_u = WrapOf(wraps, JoinPointer("/samplers", *sampler), "wrapS");
    use.wrap_v = WrapOf(wraps, JoinPointer("/samplers", *sampler), "wrapT");
  }
  return use;
}

bool IsPngOrJpeg(const std::vector<unsigned char>& stored) {
  constexpr unsigned char kPng[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  constexpr unsigned char kJpeg[] = {0xFF, 0xD8, 0xFF};
  const auto starts = [&](const auto& magic) {
    return stored.size() > sizeof magic && std::memcmp(stored.data(), magic, sizeof magic) == 0;
  };
  return starts(kPng) || starts(kJpeg);
}

// All channels, as they are stored.
struct Pixels {
  int width = 0, height = 0, channels = 0;
  std::unique_ptr<stbi_uc, void (*)(void*)> bytes{nullptr, stbi_image_free};

  std::size_t count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

Pixels PixelsOf(const std::vector<unsigned char>& stored, std::uint64_t most_pixels, const std::string& pointer) {
  Pixels pixels;
  const int bytes = static_cast<int>(stored.size());  // at most kMaxImageBytes
  if (!IsPngOrJpeg(stored) ||
      stbi_info_from_memory(stored.data(), bytes, &pixels.width, &pixels.height, &pixels.channels) == 0) {
    throw LoadError(pointer, "is neither PNG nor JPEG");
  }
  if (!(pixels.width > 0 && pixels.height > 0 && pixels.count() <= most_pixels)) {
    throw LoadError(pointer, "has " + std::to_string(pixels.width) + " x " + std::to_string(pixels.height) +
                                 " pixels, the limit is " + std::to_string(kMaxImagePixels) + " in all, and " +
                                 std::to_string(haptics::kMaxTexels) + " with the images before it");
  }
  pixels.bytes.reset(stbi_load_from_memory(stored.data(), bytes, &pixels.width, &pixels.height, &pixels.channels, 0));
  if (!pixels.bytes || pixels.channels < 1) throw LoadError(pointer, "cannot be decoded; the image is damaged");
  return pixels;
}

// The first channel: linear, whatever colour the file says it is.
haptics::InputImage RedOf(const Pixels& pixels) {
  haptics::InputImage image;
  image.width = static_cast<std::uint32_t>(pixels.width);
  image.height = static_cast<std::uint32_t>(pixels.height);
  image.texels.resize(pixels.count());
  for (std::size_t i = 0; i < image.texels.size(); ++i)
    image.texels[i] = pixels.bytes.get()[i * static_cast<std::size_t>(pixels.channels)];
  return image;
}

MadeRelief ReliefOf(const Pixels& pixels, const std::string& pointer, const base::WorkWatch& watch) {
  if (pixels.channels < 3) throw LoadError(pointer, "is gray, and normals have three channels");
  const NormalPixels normals{.pixels = {pixels.bytes.get(), pixels.count() * static_cast<unsigned>(pixels.channels)},
                             .width = static_cast<std::uint32_t>(pixels.width),
                             .height = static_cast<std::uint32_t>(pixels.height),
                             .channels = static_cast<std::uint32_t>(pixels.channels)};
  return ReliefOf(normals, watch);
}

}  // namespace

std::optional<TextureUse> ReadTextureUse(const Json& root, const Json& list, const std::string& pointer,
                                         Warnings& warnings) {
  std::optional<TextureUse> best;
  std::size_t best_type = std::size(kTypes);
  // The standard has a list; a single entry is what a person writes.
  const std::span<const Json> entries = list.is_array() ? list.elements() : std::span(&list, 1);
  for (std::size_t i = 0; i < std::min(entries.size(), kMaxEntries); ++i) {
    const std::string place = list.is_array() ? JoinPointer(pointer, i) : pointer;
    try {
      const std::string type = FindString(entries[i], place, "type", kTypes[0]);
      const auto row = std::find(std::begin(kTypes), std::end(kTypes), type);
      if (row == std::end(kTypes)) throw LoadError(JoinPointer(place, "type"), "is " + type + ": not rendered");
      const Json* info = FindObject(entries[i], place, "texture");
      if (!info) throw LoadError(JoinPointer(place, "texture"), "is missing");
      const auto rank = static_cast<std::size_t>(row - std::begin(kTypes));
      if (rank >= best_type) continue;
      best = UseOf(root, *info, JoinPointer(place, "texture"));
      best_type = rank;
    } catch (const LoadError& error) {
      warnings.Add(place, std::string("is not used: ") + error.what());
    }
  }
  return best;
}

std::optional<TextureUse> ReadNormalTexture(const Json& root, const Json& material, const std::string& pointer,
                                            Warnings& warnings) {
  const std::string place = JoinPointer(pointer, "normalTexture");
  try {
    const Json* info = FindObject(material, pointer, "normalTexture");
    if (!info) return std::nullopt;
    TextureUse use = UseOf(root, *info, place);
    use.as_relief = true;
    if (const Json* scale = FindMember(*info, "scale")) use.relief_scale = scale->number();
    if (!(std::abs(use.relief_scale) <= 100)) throw LoadError(JoinPointer(place, "scale"), "is not within 100");
    return use;
  } catch (const LoadError& error) {
    warnings.Add(place, std::string("there is no relief to feel: ") + error.what());
    return std::nullopt;
  }
}

TextureReader::Image* TextureReader::ImageOf(const TextureUse& use) {
  const auto found =
      std::find_if(images_.begin(), images_.end(), [&](const Image& image) { return image.number == use.image; });
  return found == images_.end() ? nullptr : &*found;
}

void TextureReader::Read(const TextureUse& use) {
  Image* known = ImageOf(use);
  const auto is_relief = [](const Image& image) { return image.as_relief; };
  if (use.as_relief && !(known && is_relief(*known)) &&
      std::count_if(images_.begin(), images_.end(), is_relief) == haptics::kMaxReliefs)
    return warnings_.Add(use.pointer, "is beyond the limit of " + std::to_string(haptics::kMaxReliefs) +
                                          " images with a relief: it is not felt");
  if (known) {
    (use.as_relief ? known->as_relief : known->as_red) = true;
    return;
  }
  if (images_.size() == haptics::kMaxTextures)
    return warnings_.Add(use.pointer, "is beyond the limit of " + std::to_string(haptics::kMaxTextures) +
                                          " images: 1 is used everywhere");
  Image& image = images_.emplace_back();
  image.number = use.image;
  image.pointer = JoinPointer("/images", use.image);
  (use.as_relief ? image.as_relief : image.as_red) = true;
  try {
    if (stored_bytes_ <= file_.stored_bytes()) {
      image.stored = file_.ReadImage(use.image, kMaxImageBytes);
      stored_bytes_ += image.stored.size();
    }
    if (stored_bytes_ > file_.stored_bytes()) {
      base::FreeMemory(image.stored);
      throw LoadError(image.pointer, "is among images that share their bytes; give each its own");
    }
  } catch (const LoadError& error) {
    warnings_.Add(use.pointer, std::string("has no image, 1 is used everywhere: ") + error.what());
  }
}

TextureSizes TextureReader::Measure() const {
  TextureSizes sizes;
  for (const Image& image : images_) {
    int width = 0, height = 0, channels = 0;
    sizes.stored_bytes += image.stored.size();
    if (!IsPngOrJpeg(image.stored) || stbi_info_from_memory(image.stored.data(), static_cast<int>(image.stored.size()),
                                                            &width, &height, &channels) == 0) {
      continue;  // gives a warning when it is decoded, and no texels
    }
    const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (pixels > kMaxImagePixels) continue;
    if (image.as_red) sizes.texels += pixels;
    if (image.as_relief) sizes.texels += std::min(pixels, kMostReliefPixels) * 2;
    sizes.any_relief = sizes.any_relief || image.as_relief;
    sizes.largest_samples = std::max(sizes.largest_samples, 4 * pixels);
  }
  sizes.texels = std::min<std::uint64_t>(sizes.texels, haptics::kMaxTexels);
  return sizes;
}

std::uint64_t TextureReader::DecodeImage(Image& image, std::uint64_t most_pixels, const base::WorkWatch& watch) {
  const Pixels pixels = PixelsOf(image.stored, most_pixels, image.pointer);
  if (image.as_red) image.red.image = RedOf(pixels);
  if (!image.as_relief) return pixels.count();
  MadeRelief made = ReliefOf(pixels, image.pointer, watch);
  image.heights = std::move(made.relief);
  image.relief.image = std::move(made.bands);
  return pixels.count();
}

void TextureReader::Decode(const base::WorkWatch& watch) {
  std::uint64_t left = haptics::kMaxTexels;
  for (Image& image : images_) {
    // The bands of a relief have at most twice the texels, of a large image fewer, but it takes time.
    const std::uint64_t share = (image.as_red ? 1U : 0U) + (image.as_relief ? 2U : 0U);
    if (image.stored.empty() || share == 0) continue;
    watch.Ask();
    try {
      left -= share * DecodeImage(image, std::min(kMaxImagePixels, left / share), watch);
      ++decoded_;
    } catch (const LoadError& error) {
      warnings_.Add(image.pointer,
                    std::string(image.as_red ? "is not used, 1 is used everywhere: " : "is not felt: ") + error.what());
    }
    base::FreeMemory(image.stored);
  }
}

std::int32_t TextureReader::AddTo(haptics::SceneInput& input, const TextureUse& use, Image& image) {
  Channel& channel = use.as_relief ? image.relief : image.red;
  const std::size_t count = use.as_relief ? input.reliefs.size() : input.textures.size();
  const std::size_t most = use.as_relief ? haptics::kMaxReliefs : haptics::kMaxTextures;
  if (!channel.there()) return -1;
  if (count == most) {
    warnings_.Add(use.pointer, "is beyond the limit of " + std::to_string(most) +
                                   (use.as_relief ? " reliefs: it is not felt" : " textures: 1 is used everywhere"));
    return -1;
  }
  if (channel.index < 0) {
    channel.index = static_cast<std::int32_t>(input.images.size());
    input.images.push_back(std::move(channel.image));
    channel.image = {};
  }
  const haptics::InputTexture texture{static_cast<std::uint32_t>(channel.index), use.uv_set, use.wrap_u, use.wrap_v,
                                      use.to_image};
  if (!use.as_relief) {
    input.textures.push_back(texture);
  } else {
    haptics::InputRelief& relief = input.reliefs.emplace_back(image.heights);
    relief.texture = texture;
    for (float& step : relief.steps) step *= static_cast<float>(use.relief_scale);
  }
  return static_cast<std::int32_t>(count);
}

std::int32_t TextureReader::IndexOf(const TextureUse& use, haptics::SceneInput& input) {
  const auto found = std::find_if(made_.begin(), made_.end(), [&](const Made& made) { return made.use == use; });
  if (found != made_.end()) return found->index;
  Image* image = ImageOf(use);
  if (made_.size() == kMaxMade) return -1;
  const std::int32_t index = image ? AddTo(input, use, *image) : -1;
  made_.push_back({use, index});
  return index;
}

}  // namespace omni::scene
