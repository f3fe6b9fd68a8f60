// JSON of untrusted files: bounded parsing, and typed fields whose errors carry a JSON pointer.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/files/json_document.h"

namespace omni::scene {

// A message may quote a file's own words, and goes to terminals and logs: no control characters, and a bounded length.
std::string Printable(std::string message);

// Why a file was refused. Thrown inside this module only; LoadSceneFile turns it into base::Error.
class LoadError : public std::runtime_error {
 public:
  // `pointer`: JSON pointer of the culprit ("" = the file as a whole); `what`: what is wrong, the limit, what to do.
  LoadError(const std::string& pointer, const std::string& what)
      : std::runtime_error(Printable(pointer.empty() ? what : pointer + ": " + what)) {}
};

using Json = base::JsonValue;

// 100,000 nodes have 40 values each: a node has some 10, a mesh of its own with accessors some 50. As a document they
// take at most 128 MB.
inline constexpr base::JsonLimits kSceneJson{
    .bytes = 64u << 20, .values = 4'000'000, .members = 4'000'000, .depth = 128};
inline constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON", of a binary glTF file

// Throws LoadError on a syntax error, a limit of kSceneJson, a key that is there twice, or a root that is no object.
base::JsonDocument ParseJson(std::string_view text);

// A value as text, cut to 60 characters; for messages.
std::string ValueText(const Json& value);

// RFC 6901: "/" and "~" in keys are escaped.
std::string JoinPointer(const std::string& pointer, std::string_view key);
std::string JoinPointer(const std::string& pointer, std::uint64_t index);

// The member `key`, or nullptr when absent or when `parent` is no object.
const Json* FindMember(const Json& parent, std::string_view key);

// As Find, but a member of another type is an error.
const Json* FindObject(const Json& parent, const std::string& pointer, const char* key);
const Json* FindArray(const Json& parent, const std::string& pointer, const char* key);
std::string FindString(const Json& parent, const std::string& pointer, const char* key, const std::string& fallback);

// Element `index` of the root array `key`, which must hold an object there. Throws LoadError otherwise.
const Json& ElementOf(const Json& root, const char* key, std::uint64_t index);
std::uint64_t CountOf(const Json& root, const char* key);

// A whole number in [0, maximum]; absent: `fallback`, or an error when there is none.
std::uint64_t ReadInteger(const Json& parent, const std::string& pointer, const char* key, std::uint64_t maximum,
                          std::optional<std::uint64_t> fallback);

// An index into something with `count` elements.
std::uint32_t IndexIn(const Json& value, const std::string& pointer, std::uint64_t count);

// The same of a member; absent: nullopt.
std::optional<std::uint32_t> ReadIndex(const Json& parent, const std::string& pointer, const char* key,
                                       std::uint64_t count);

// Exactly `count` finite numbers; absent: empty.
std::vector<double> ReadNumberArray(const Json& parent, const std::string& pointer, const char* key, std::size_t count);

}  // namespace omni::scene
