#include "tests/runtime/graphics/png.h"

#include <stb/stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace omni::runtime {
namespace {

uint8_t ToSrgb(float linear) {
  const float part = linear <= 0.0031308F ? linear * 12.92F : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
  return static_cast<uint8_t>(std::lround(std::clamp(part, 0.0F, 1.0F) * 255));
}

// Called by stb, perhaps in parts.
void Append(void* text, void* data, int size) {
  static_cast<std::string*>(text)->append(static_cast<const char*>(data), static_cast<size_t>(size));
}

}  // namespace

bool SaveText(const std::string& text, const std::string& file) {
  const std::string part = file + ".part";
  std::FILE* const out = std::fopen(part.c_str(), "wb");
  if (out == nullptr) return false;
  const bool written = std::fwrite(text.data(), 1, text.size(), out) == text.size();
  return std::fclose(out) == 0 && written && std::rename(part.c_str(), file.c_str()) == 0;
}

bool SavePng(const Picture& picture, const std::string& file) {
  std::vector<uint8_t> bytes;
  bytes.reserve(picture.rgba.size() / 4 * 3);
  for (size_t i = 0; i < picture.rgba.size(); i += 4) {
    for (size_t j = i; j < i + 3; ++j) bytes.push_back(ToSrgb(picture.rgba[j]));
  }
  stbi_write_png_compression_level = 1;  // the frame waits for it
  stbi_write_force_png_filter = 0;
  std::string png;
  const auto width = static_cast<int>(picture.width);
  const int made =
      stbi_write_png_to_func(&Append, &png, width, static_cast<int>(picture.height), 3, bytes.data(), width * 3);
  return made != 0 && SaveText(png, file);
}

}  // namespace omni::runtime
