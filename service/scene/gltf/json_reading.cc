#include "service/scene/gltf/json_reading.h"

#include <charconv>
#include <cmath>
#include <limits>

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

namespace {

constexpr std::size_t kMostShown = 60;

// Appends to `text` until it is longer than what is shown.
void AppendShown(const Json& value, std::string& text) {
  if (text.size() > kMostShown) return;
  if (value.is_object()) {
    text += '{';
    for (const base::JsonMember& member : value.members()) {
      if (text.size() > kMostShown) return;
      if (text.back() != '{') text += ',';
      AppendShown(Json(member.key), text);
      text += ':';
      AppendShown(member.value, text);
    }
    text += '}';
  } else if (value.is_array()) {
    text += '[';
    for (const Json& element : value.elements()) {
      if (text.size() > kMostShown) return;
      if (text.back() != '[') text += ',';
      AppendShown(element, text);
    }
    text += ']';
  } else if (value.is_text()) {
    text += '"' + std::string(value.text().substr(0, kMostShown)) + '"';
  } else if (value.is_number()) {
    char digits[32];
    const double number = value.number();
    const char* const end = value.whole() ? std::to_chars(digits, std::end(digits), *value.whole()).ptr
                                          : std::to_chars(digits, std::end(digits), number).ptr;
    text.append(static_cast<const char*>(digits), end);
    if (!value.whole() && number == std::trunc(number) && std::abs(number) < 1e15) text += ".0";
  } else {
    text += value.is_null() ? "null" : value.boolean() ? "true" : "false";
  }
}

}  // namespace

std::string ValueText(const Json& value) {
  std::string text;
  AppendShown(value, text);
  if (text.size() > kMostShown) text = text.substr(0, kMostShown - 3) + "...";
  return text;
}

base::JsonDocument ParseJson(std::string_view text) {
  base::Result<base::JsonDocument> document = base::JsonDocument::Parse(text, kSceneJson);
  if (!document.ok()) throw LoadError("", document.error());
  if (!document->root().is_object()) throw LoadError("", "JSON root must be an object; this is not a glTF document");
  return std::move(*document);
}

std::string JoinPointer(const std::string& pointer, std::string_view key) {
  std::string joined = pointer + "/";
  for (const char c : key) {
    if (c == '~') {
      joined += "~0";
    } else if (c == '/') {
      joined += "~1";
    } else {
      joined += c;
    }
  }
  return joined;
}

std::string JoinPointer(const std::string& pointer, std::uint64_t index) {
  return pointer + "/" + std::to_string(index);
}

const Json* FindMember(const Json& parent, std::string_view key) { return parent.Find(key); }

const Json* FindObject(const Json& parent, const std::string& pointer, const char* key) {
  const Json* found = FindMember(parent, key);
  if (found && !found->is_object())
    throw LoadError(JoinPointer(pointer, key), "is " + ValueText(*found) + ", must be an object");
  return found;
}

const Json* FindArray(const Json& parent, const std::string& pointer, const char* key) {
  const Json* found = FindMember(parent, key);
  if (found && !found->is_array())
    throw LoadError(JoinPointer(pointer, key), "is " + ValueText(*found) + ", must be an array");
  return found;
}

std::string FindString(const Json& parent, const std::string& pointer, const char* key, const std::string& fallback) {
  const Json* found = FindMember(parent, key);
  if (!found) return fallback;
  if (!found->is_text()) throw LoadError(JoinPointer(pointer, key), "is " + ValueText(*found) + ", must be a string");
  return std::string(found->text());
}

std::uint64_t CountOf(const Json& root, const char* key) {
  const Json* array = FindArray(root, "", key);
  return array ? array->elements().size() : 0;
}

const Json& ElementOf(const Json& root, const char* key, std::uint64_t index) {
  const auto pointer = [&] { return JoinPointer(JoinPointer("", key), index); };
  const Json* array = FindArray(root, "", key);
  if (!array || index >= array->elements().size()) throw LoadError(pointer(), "does not exist");
  const Json& element = array->elements()[static_cast<std::size_t>(index)];
  if (!element.is_object()) throw LoadError(pointer(), "is " + ValueText(element) + ", must be an object");
  return element;
}

std::uint64_t ReadInteger(const Json& parent, const std::string& pointer, const char* key, std::uint64_t maximum,
                          std::optional<std::uint64_t> fallback) {
  const Json* found = FindMember(parent, key);
  if (!found && fallback) return *fallback;
  if (!found) throw LoadError(JoinPointer(pointer, key), "is missing");
  const std::optional<std::uint64_t> number = found->whole();  // 2.0 and -1 are refused
  if (!number || *number > maximum) {
    throw LoadError(JoinPointer(pointer, key),
                    "is " + ValueText(*found) + ", must be a whole number from 0 to " + std::to_string(maximum));
  }
  return *number;
}

std::uint32_t IndexIn(const Json& value, const std::string& pointer, std::uint64_t count) {
  const std::optional<std::uint64_t> index = value.whole();
  if (!index || *index >= count || *index > std::numeric_limits<std::uint32_t>::max())
    throw LoadError(pointer, "is " + ValueText(value) + ", must be an index below " + std::to_string(count));
  return static_cast<std::uint32_t>(*index);
}

std::optional<std::uint32_t> ReadIndex(const Json& parent, const std::string& pointer, const char* key,
                                       std::uint64_t count) {
  const Json* found = FindMember(parent, key);
  if (!found) return std::nullopt;
  return IndexIn(*found, JoinPointer(pointer, key), count);
}

std::vector<double> ReadNumberArray(const Json& parent, const std::string& pointer, const char* key,
                                    std::size_t count) {
  const Json* found = FindArray(parent, pointer, key);
  if (!found) return {};
  if (found->elements().size() != count) {
    throw LoadError(JoinPointer(pointer, key), "has " + std::to_string(found->elements().size()) +
                                                   " elements, must have " + std::to_string(count));
  }
  std::vector<double> numbers;
  for (const Json& element : found->elements()) {
    const double number = element.number();
    if (!(std::abs(number) <= 1e12)) {
      throw LoadError(JoinPointer(JoinPointer(pointer, key), numbers.size()),
                      "is " + ValueText(element) + ", must be a number within +-1e12");
    }
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace omni::scene
