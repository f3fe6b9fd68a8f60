#include "service/scene/gltf/load_error.h"

namespace omni::scene {

std::string Printable(std::string message) {
  constexpr std::size_t kMost = 1000;
  if (message.size() > kMost) {
    // Names and keys come first, what to do about it last.
    message.replace(kMost / 2, message.size() - kMost, "...");
  }
  for (char& c : message) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F) c = '?';
  }
  return message;
}

}  // namespace omni::scene
