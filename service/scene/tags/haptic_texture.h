// Textures that haptic tags name: which image, how it is sampled, and its red channel. No other image of a file is
// read. stb_image is confined to haptic_texture.cc.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/base/work_watch.h"
#include "service/haptics/scene/scene_input.h"
#include "service/scene/gltf/gltf_file.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/tags/haptic_tag.h"

namespace omni::scene {

inline constexpr std::uint64_t kMaxImageBytes = 64ull << 20;   // as stored
inline constexpr std::uint64_t kMaxImagePixels = 16ull << 20;  // 4096 x 4096

// One of the lists stiffness, friction or vibrotactileTexture of an MPEG haptic material. The entry of type
// High_Resolution is taken, else Low_Resolution, else Other; Reference (an effect of another file) is not rendered.
// Anything wrong with it: a warning, and no texture.
std::optional<TextureUse> ReadTextureUse(const Json& root, const Json& list, const std::string& pointer,
                                         Warnings& warnings);

// The normalTexture of a glTF material, as a relief, if it has one. Something wrong with it: a warning.
std::optional<TextureUse> ReadNormalTexture(const Json& root, const Json& material, const std::string& pointer,
                                            Warnings& warnings);

// Of all images that were read.
struct TextureSizes {
  std::uint64_t stored_bytes = 0, texels = 0;
  std::uint64_t largest_samples = 0;  // texels times channels, of one image
  bool any_relief = false;
};

class TextureReader {
 public:
  TextureReader(GltfFile& file, Warnings& warnings) : file_(file), warnings_(warnings) {}

  // Reads the stored bytes of the image, once per image. A missing image: a warning, and `IndexOf` returns -1.
  void Read(const TextureUse& use);

  // By the headers of what was read, before it is decoded.
  TextureSizes Measure() const;

  // Decodes what was read (PNG, JPEG). Once, before IndexOf.
  void Decode(const base::WorkWatch& watch);

  // Index into `input.textures`, or of a relief into `input.reliefs`, made on first use; -1: there is none.
  std::int32_t IndexOf(const TextureUse& use, haptics::SceneInput& input);

  std::uint32_t images_decoded() const { return decoded_; }

 private:
  struct Channel {
    haptics::InputImage image;  // empty: could not be decoded, or is not used
    std::int32_t index = -1;    // in the scene's list
    bool there() const { return index >= 0 || !image.texels.empty(); }
  };
  struct Image {
    std::uint32_t number = 0;  // in the document
    std::string pointer;
    std::vector<unsigned char> stored;
    bool as_red = false, as_relief = false;
    Channel red, relief;
    haptics::InputRelief heights;
  };
  struct Made {
    TextureUse use;
    std::int32_t index;
  };
  Image* ImageOf(const TextureUse& use);
  std::uint64_t DecodeImage(Image& image, std::uint64_t most_pixels, const base::WorkWatch& watch);  // its pixels
  std::int32_t AddTo(haptics::SceneInput& input, const TextureUse& use, Image& image);

  GltfFile& file_;
  Warnings& warnings_;
  std::vector<Image> images_;
  std::vector<Made> made_;
  std::uint64_t stored_bytes_ = 0;  // of all images that were read
  std::uint32_t decoded_ = 0;
};

}  // namespace omni::scene
