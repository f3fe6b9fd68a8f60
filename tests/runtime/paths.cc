// Paths and their atoms.

#include <array>
#include <cstring>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

constexpr std::array<std::string_view, 4> kTopLevel = {"/user/hand/left", "/user/hand/right", "/user/head",
                                                       "/user/gamepad"};

bool IsLevelCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
}

// Chapter "Well-formed path strings": levels of [a-z0-9-_.], none empty, none of periods only, no trailing slash.
bool IsWellFormed(std::string_view text) {
  if (text.empty() || text.front() != '/') return false;
  while (!text.empty()) {
    text.remove_prefix(1);
    const std::string_view level = text.substr(0, text.find('/'));
    if (level.empty() || level.find_first_not_of('.') == std::string_view::npos) return false;
    for (const char c : level) {
      if (!IsLevelCharacter(c)) return false;
    }
    text.remove_prefix(level.size());
  }
  return true;
}

}  // namespace

XrResult TwoCallString(std::string_view text, uint32_t capacity, uint32_t* count, char* out) {
  const auto copy = [text](uint32_t i, char& c) { c = i < text.size() ? text[i] : '\0'; };
  return TwoCall(static_cast<uint32_t>(text.size() + 1), capacity, count, out, copy);
}

XrPath InternPath(Instance& instance, std::string_view text) {
  const auto [entry, is_new] =
      instance.path_ids.try_emplace(std::string(text), static_cast<uint32_t>(instance.paths.size()));
  if (is_new) instance.paths.emplace_back(text);
  return uint64_t{instance.serial} << 32 | (uint64_t{entry->second} + 1);
}

const std::string* PathText(const Instance& instance, XrPath path) {
  const uint64_t id = path & 0xffffffffU;
  if (path >> 32 != instance.serial || id == 0 || id > instance.paths.size()) return nullptr;
  return &instance.paths[id - 1];
}

int HandOf(const Instance& instance, XrPath path) {
  const std::string* const text = PathText(instance, path);
  for (int hand = 0; text != nullptr && hand < kHands; ++hand) {
    if (*text == kHandPaths[hand]) return hand;
  }
  return -1;
}

bool IsTopLevelPath(const std::string& text) {
  for (const std::string_view top : kTopLevel) {
    if (text == top) return true;
  }
  return false;
}

XrResult StringToPath(XrInstance instance, const char* text, XrPath* path) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(text != nullptr && path != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const size_t length = strnlen(text, XR_MAX_PATH_LENGTH);
  OMNI_REQUIRE(length < XR_MAX_PATH_LENGTH && IsWellFormed({text, length}), XR_ERROR_PATH_FORMAT_INVALID);
  *path = InternPath(*owner, {text, length});
  return XR_SUCCESS;
}

XrResult PathToString(XrInstance instance, XrPath path, uint32_t capacity, uint32_t* count, char* buffer) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  const std::string* const text = PathText(*owner, path);
  OMNI_REQUIRE(text != nullptr, XR_ERROR_PATH_INVALID);
  return TwoCallString(*text, capacity, count, buffer);
}

}  // namespace omni::runtime
