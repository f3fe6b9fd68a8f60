// JSON text from an untrusted source. One pass counts its values and finds what is wrong with it before
// anything is built; a second one puts the values into three blocks of the size that was counted. So cost and memory
// are bounded by JsonLimits, nothing is allocated afterwards, and freeing a document allocates nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/result.h"

namespace omni::base {

// A text beyond a limit is rejected with a message that names the limit. A document takes at most 32 bytes per value
// plus its texts; parsing it as much again as its longest text, and 12 bytes for each object and array.
struct JsonLimits {
  std::size_t bytes = 1 << 20;  // of the text, below 4 GiB
  std::size_t values = 20'000;  // objects, arrays, texts, numbers, true, false and null
  std::size_t members = 1'000;  // of one object
  std::size_t depth = 64;       // nesting of objects and arrays
  bool comments = false;        // allowed, as in C
};

struct JsonMember;

// One value of a JsonDocument, valid as long as the document. Accessors of another kind return empty, NaN or nullopt.
class JsonValue {
 public:
  enum class Kind : std::uint8_t { kNull, kBoolean, kWhole, kNumber, kText, kArray, kObject };

  JsonValue() = default;
  explicit JsonValue(bool value) : kind_(Kind::kBoolean) { content_.whole = value ? 1 : 0; }
  explicit JsonValue(std::uint64_t value) : kind_(Kind::kWhole) { content_.whole = value; }
  explicit JsonValue(double value) : kind_(Kind::kNumber) { content_.number = value; }
  explicit JsonValue(std::string_view text) : size_(static_cast<std::uint32_t>(text.size())), kind_(Kind::kText) {
    content_.text = text.data();
  }
  JsonValue(const JsonValue* elements, std::uint32_t size) : size_(size), kind_(Kind::kArray) {
    content_.elements = elements;
  }
  JsonValue(const JsonMember* members, std::uint32_t size) : size_(size), kind_(Kind::kObject) {
    content_.members = members;
  }

  bool is_null() const { return kind_ == Kind::kNull; }
  bool is_boolean() const { return kind_ == Kind::kBoolean; }
  bool is_number() const { return kind_ == Kind::kWhole || kind_ == Kind::kNumber; }
  bool is_text() const { return kind_ == Kind::kText; }
  bool is_array() const { return kind_ == Kind::kArray; }
  bool is_object() const { return kind_ == Kind::kObject; }
  const char* kind_name() const;

  bool boolean() const { return is_boolean() && content_.whole != 0; }
  double number() const;
  // A number written with digits only: 7, but not -7 or 7.0.
  std::optional<std::uint64_t> whole() const;
  std::string_view text() const { return is_text() ? std::string_view(content_.text, size_) : std::string_view(); }
  std::span<const JsonValue> elements() const;
  std::span<const JsonMember> members() const;  // sorted by their unique keys
  const JsonValue* Find(std::string_view key) const;

 private:
  union {
    std::uint64_t whole = 0;
    double number;
    const char* text;
    const JsonValue* elements;
    const JsonMember* members;
  } content_;
  std::uint32_t size_ = 0;
  Kind kind_ = Kind::kNull;
};

struct JsonMember {
  std::string_view key;
  JsonValue value;
};

class JsonDocument {
 public:
  JsonDocument() : elements_(1) {}  // null
  JsonDocument(JsonDocument&&) = default;
  JsonDocument& operator=(JsonDocument&&) = default;  // values point into the blocks: there are no copies
  // The error says what is wrong and where, not in which file. May throw std::bad_alloc.
  static Result<JsonDocument> Parse(std::string_view text, const JsonLimits& limits);

  const JsonValue& root() const { return elements_.front(); }
  std::size_t memory_bytes() const {
    return elements_.capacity() * sizeof(JsonValue) + members_.capacity() * sizeof(JsonMember) + text_.capacity();
  }

 private:
  std::vector<JsonValue> elements_;  // the root, then those of arrays
  std::vector<JsonMember> members_;  // of objects
  std::vector<char> text_;
};

// Whether the text is JSON within the limits; to be checked before it is passed to another parser.
Status CheckJson(std::string_view text, const JsonLimits& limits);

// Reads JSON that another program has sent, perhaps of another version: missing values and other types become a
// default.

// Null when the text is no JSON, or exceeds the default JsonLimits.
nlohmann::json ParseJsonOrNull(const std::string& text);

// The value at a JSON pointer ("/tick/count"); null: it is missing.
const nlohmann::json* ValueAt(const nlohmann::json& document, const char* pointer);

// NaN when missing or no number.
double NumberAt(const nlohmann::json& document, const char* pointer);

bool TrueAt(const nlohmann::json& document, const char* pointer);

// A string as it was sent, not made printable; empty when missing or no string.
std::string StringAt(const nlohmann::json& document, const char* pointer);

// An array to walk over; empty when missing or no array.
const nlohmann::json& ArrayAt(const nlohmann::json& document, const char* pointer);

}  // namespace omni::base
