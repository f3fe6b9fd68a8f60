// JSON of files that nobody vouches for: checked parsing, and typed fields whose errors carry a JSON pointer.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace omni::scene {

using Json = nlohmann::json;

inline constexpr int kMaxJsonDepth = 128;  // deeper nesting is refused before any parser recurses over it

// Throws LoadError on a syntax error, nesting over kMaxJsonDepth, a key that is there twice, or a root that is no
// object.
Json ParseJson(std::string_view text);

// A value as text, cut to 60 characters; for messages.
std::string Shown(const Json& value);

// RFC 6901: "/" and "~" in keys are escaped.
std::string Join(const std::string& pointer, std::string_view key);
std::string Join(const std::string& pointer, std::uint64_t index);

// The member `key`, or nullptr when absent or when `parent` is no object.
const Json* Find(const Json& parent, const char* key);

// As Find, but a member of another type is an error.
const Json* FindObject(const Json& parent, const std::string& pointer, const char* key);
const Json* FindArray(const Json& parent, const std::string& pointer, const char* key);
std::string FindString(const Json& parent, const std::string& pointer, const char* key, const std::string& fallback);

// Element `index` of the root array `key`, which must hold an object there. Throws LoadError otherwise.
const Json& ElementOf(const Json& root, const char* key, std::uint64_t index);
std::uint64_t CountOf(const Json& root, const char* key);

// A whole number in [0, maximum]; absent: `fallback`, or an error when there is none.
std::uint64_t Whole(const Json& parent, const std::string& pointer, const char* key, std::uint64_t maximum,
                    std::optional<std::uint64_t> fallback);

// An index into something with `count` elements; absent: nullopt.
std::optional<std::uint32_t> Index(const Json& parent, const std::string& pointer, const char* key,
                                   std::uint64_t count);

// Exactly `count` finite numbers; absent: empty.
std::vector<double> Numbers(const Json& parent, const std::string& pointer, const char* key, std::size_t count);

}  // namespace omni::scene
