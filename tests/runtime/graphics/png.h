#pragma once
// Files of pictures, replaced as a whole: a reader never meets half of one.

#include <string>

#include "tests/runtime/graphics/graphics.h"

namespace omni::runtime {

// As 8-bit sRGB without alpha. False: the file could not be written.
bool SavePng(const Picture& picture, const std::string& file);
bool SaveText(const std::string& text, const std::string& file);

}  // namespace omni::runtime
