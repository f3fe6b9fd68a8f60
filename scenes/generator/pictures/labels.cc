#include "scenes/generator/pictures/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "scenes/generator/pictures/rest_surface.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_easy_font.h>
#pragma GCC diagnostic pop

namespace omni::scenes {
namespace {

constexpr std::array<std::uint8_t, 3> kInk{250, 250, 250}, kShade{28, 32, 38};
constexpr int kLetterHeight = 12;  // of the font, before it is scaled

struct Box {
  int left, top, right, bottom;  // pixels, right and bottom beyond the last
};

void FillBox(const Box& box, const std::array<std::uint8_t, 3>& colour, double cover, Pixels pixels) {
  for (int y = std::max(0, box.top); y < std::min(pixels.height, box.bottom); ++y) {
    for (int x = std::max(0, box.left); x < std::min(pixels.width, box.right); ++x) {
      std::uint8_t* to = &pixels.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels.width) +
                                          static_cast<std::size_t>(x))];
      for (std::size_t k = 0; k < 3; ++k) {
        to[k] = static_cast<std::uint8_t>(std::lround((1 - cover) * to[k] + cover * colour[k]));
      }
    }
  }
}

std::string Printable(std::string text) {
  for (char& c : text) c = c >= ' ' && c <= '~' ? c : '?';
  return text;
}

int WidthOf(std::string text, int scale) { return stb_easy_font_width(text.data()) * scale; }

// The font's letters are boxes: four corners of 16 bytes each, the first three floats a place.
void DrawWords(std::string text, int left, int top, int scale, Pixels pixels) {
  std::vector<char> corners(text.size() * 300 + 64);
  const int boxes = stb_easy_font_print(0, 0, text.data(), nullptr, corners.data(), static_cast<int>(corners.size()));
  for (int i = 0; i < boxes; ++i) {
    const auto at = [&](int corner, std::size_t axis) {
      float value = 0;
      std::memcpy(&value, &corners[static_cast<std::size_t>(i) * 64 + static_cast<std::size_t>(corner) * 16 + 4 * axis],
                  sizeof value);
      return static_cast<int>(std::lround(value * static_cast<float>(scale)));
    };
    FillBox({left + at(0, 0), top + at(0, 1), left + at(2, 0), top + at(2, 1)}, kInk, 1, pixels);
  }
}

int ScaleOf(Pixels pixels) { return std::max(1, pixels.width / 320); }

std::uint8_t AsByte(double linear) {
  const double srgb = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::clamp(srgb * 255 + 0.5, 0.0, 255.0));
}

}  // namespace

void DrawCaption(const std::string& text, Pixels pixels) {
  const int scale = ScaleOf(pixels), margin = 5 * scale;
  const std::string words = Printable(text);
  FillBox({0, pixels.height - kLetterHeight * scale - margin, pixels.width, pixels.height}, kShade, 0.8, pixels);
  DrawWords(words, (pixels.width - WidthOf(words, scale)) / 2, pixels.height - kLetterHeight * scale, scale, pixels);
}

void DrawDisplacementScale(double displacement_max_m, Pixels pixels) {
  const int scale = ScaleOf(pixels), width = 10 * scale, height = pixels.height / 2;
  const int left = pixels.width - 56 * scale, top = pixels.height / 8;
  FillBox({left - 5 * scale, top - 20 * scale, pixels.width - 4 * scale, top + height + 10 * scale}, kShade, 0.8,
          pixels);
  DrawWords("moved by", left, top - 15 * scale, scale, pixels);
  for (int y = 0; y < height; ++y) {
    const Vec c = DisplacementColour(1 - static_cast<double>(y) / height, Vec(0.25));
    FillBox({left, top + y, left + width, top + y + 1}, {AsByte(c.x), AsByte(c.y), AsByte(c.z)}, 1, pixels);
  }
  for (int i = 0; i <= 2; ++i) {
    char words[16];
    std::snprintf(words, sizeof(words), "%.1f mm", displacement_max_m * 1e3 * i / 2);
    DrawWords(words, left + width + 2 * scale, top + height * (2 - i) / 2 - 4 * scale, scale, pixels);
  }
}

}  // namespace omni::scenes
