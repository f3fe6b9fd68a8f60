#include "service/base/files/json_document.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

namespace omni::base {
namespace {

using Parser = nlohmann::json;

// The parser's message quotes the text, which may be long and contain control characters.
std::string Quotable(std::string_view said) {
  constexpr std::size_t kMost = 200;
  if (const std::size_t end = said.find("] "); said.starts_with("[json.exception") && end != said.npos)
    said.remove_prefix(end + 2);
  std::string text(said.substr(0, kMost));
  for (char& c : text) {
    if (!(c >= 0x20 && c < 0x7F)) c = '?';
  }
  return said.size() > kMost ? text + "..." : text;
}

// Receives the parser's events. All but the last return whether to continue.
class Events {
 public:
  const std::string& problem() const { return problem_; }

  bool binary(Parser::binary_t&) { return Refuse("is not JSON text"); }
  bool parse_error(std::size_t, const std::string&, const Parser::exception& error) {
    return Refuse("JSON cannot be parsed: " + Quotable(error.what()));
  }

 protected:
  bool Refuse(std::string problem) {
    problem_ = std::move(problem);
    return false;
  }

 private:
  std::string problem_;
};

class Counter : public Events {
 public:
  explicit Counter(const JsonLimits& limits) : limits_(limits) {}

  bool null() { return Count(); }
  bool boolean(bool) { return Count(); }
  bool number_integer(std::int64_t) { return Count(); }
  bool number_unsigned(std::uint64_t) { return Count(); }
  bool number_float(double, const std::string&) { return Count(); }
  bool string(std::string& text) {
    text_bytes_ += text.size();
    return Count();
  }
  bool key(std::string& text) {
    text_bytes_ += text.size();
    ++members_;
    if (sizes_[open_.back()] < limits_.members) return true;
    return Refuse("has a JSON object of more than " + std::to_string(limits_.members) + " members, the limit");
  }
  bool start_object(std::size_t) { return Open(); }
  bool start_array(std::size_t) { return Open(); }
  bool end_object() { return Close(); }
  bool end_array() { return Close(); }

  // Of all objects and arrays in the order in which they begin: their members or elements.
  const std::vector<std::uint32_t>& sizes() const { return sizes_; }
  std::size_t members() const { return members_; }
  std::size_t elements() const { return values_ - members_; }
  std::size_t text_bytes() const { return text_bytes_; }

 private:
  bool Count() {
    if (!open_.empty()) ++sizes_[open_.back()];
    if (++values_ <= limits_.values) return true;
    return Refuse("has more than " + std::to_string(limits_.values) + " JSON values, the limit");
  }
  bool Open() {
    if (!Count()) return false;
    if (open_.size() == limits_.depth)
      return Refuse("JSON is nested deeper than " + std::to_string(limits_.depth) + " levels, the limit");
    open_.push_back(sizes_.size());
    sizes_.push_back(0);
    return true;
  }
  bool Close() {
    open_.pop_back();
    return true;
  }

  const JsonLimits limits_;
  std::vector<std::size_t> open_;  // indices into sizes_
  std::vector<std::uint32_t> sizes_;
  std::size_t values_ = 0, members_ = 0, text_bytes_ = 0;
};

// Runs `events` over the text; empty, or what is wrong.
template <class Handler>
std::string Run(std::string_view text, const JsonLimits& limits, Handler& events) {
  constexpr bool kWhole = true;  // nothing behind the value
  if (Parser::sax_parse(text.begin(), text.end(), &events, Parser::input_format_t::json, kWhole, limits.comments)) {
    return {};
  }
  return events.problem();
}

std::string CountText(std::string_view text, const JsonLimits& limits, Counter& counter) {
  if (text.size() > limits.bytes || text.size() > std::numeric_limits<std::uint32_t>::max()) {
    return "has " + std::to_string(text.size()) + " bytes of JSON, the limit is " + std::to_string(limits.bytes);
  }
  return Run(text, limits, counter);
}

// Stores the values in the blocks sized by the counter.
class Builder : public Events {
 public:
  // The blocks have the sizes that were counted.
  Builder(const std::vector<std::uint32_t>& sizes, JsonValue* elements, JsonMember* members, char* text)
      : sizes_(sizes), element_(elements), member_(members), text_(text) {
    open_.push_back({.element = element_++});  // of the root
  }

  bool null() { return Put(JsonValue()); }
  bool boolean(bool value) { return Put(JsonValue(value)); }
  bool number_integer(std::int64_t value) { return Put(JsonValue(static_cast<double>(value))); }
  bool number_unsigned(std::uint64_t value) { return Put(JsonValue(value)); }
  bool number_float(double value, const std::string&) { return Put(JsonValue(value)); }
  bool string(std::string& text) { return Put(JsonValue(Keep(text))); }
  bool key(std::string& text) {
    open_.back().member->key = Keep(text);
    return true;
  }
  bool start_object(std::size_t) {
    const std::uint32_t size = sizes_[container_++];
    Put(JsonValue(member_, size));
    open_.push_back({.first = member_, .member = member_});
    member_ += size;
    return true;
  }
  bool start_array(std::size_t) {
    const std::uint32_t size = sizes_[container_++];
    Put(JsonValue(element_, size));
    open_.push_back({.element = element_});
    element_ += size;
    return true;
  }
  bool end_array() {
    open_.pop_back();
    return true;
  }
  bool end_object() {
    const Place object = open_.back();
    open_.pop_back();
    std::sort(object.first, object.member, [](const auto& a, const auto& b) { return a.key < b.key; });
    const auto twice =
        std::adjacent_find(object.first, object.member, [](const auto& a, const auto& b) { return a.key == b.key; });
    if (twice == object.member) return true;
    return Refuse("JSON key \"" + Quotable(twice->key) + "\" appears twice in one object; keep one of them");
  }

 private:
  // Where the next value of an object or array goes.
  struct Place {
    JsonValue* element = nullptr;  // of an array; null: an object's members
    JsonMember* first = nullptr;
    JsonMember* member = nullptr;
  };

  bool Put(const JsonValue& value) {
    Place& place = open_.back();
    if (place.element != nullptr) {
      *place.element++ = value;
    } else {
      (place.member++)->value = value;
    }
    return true;
  }
  std::string_view Keep(const std::string& text) {
    char* const begin = text_;
    text_ = std::copy(text.begin(), text.end(), begin);
    return {begin, text.size()};
  }

  const std::vector<std::uint32_t>& sizes_;  // see Counter
  std::size_t container_ = 0;
  std::vector<Place> open_;
  JsonValue* element_;  // free space from here on
  JsonMember* member_;
  char* text_;
};

}  // namespace

const char* JsonValue::kind_name() const {
  constexpr const char* kNames[] = {"null", "true or false", "a number", "a number", "a text", "an array", "an object"};
  return kNames[static_cast<std::size_t>(kind_)];
}

double JsonValue::number() const {
  if (kind_ == Kind::kWhole) return static_cast<double>(content_.whole);
  return kind_ == Kind::kNumber ? content_.number : std::numeric_limits<double>::quiet_NaN();
}

std::optional<std::uint64_t> JsonValue::whole() const {
  return kind_ == Kind::kWhole ? std::optional(content_.whole) : std::nullopt;
}

std::span<const JsonValue> JsonValue::elements() const {
  return is_array() ? std::span(content_.elements, size_) : std::span<const JsonValue>();
}

std::span<const JsonMember> JsonValue::members() const {
  return is_object() ? std::span(content_.members, size_) : std::span<const JsonMember>();
}

const JsonValue* JsonValue::Find(std::string_view key) const {
  const std::span<const JsonMember> all = members();
  const auto found = std::lower_bound(all.begin(), all.end(), key,
                                      [](const JsonMember& member, std::string_view k) { return member.key < k; });
  return found != all.end() && found->key == key ? &found->value : nullptr;
}

Result<JsonDocument> JsonDocument::Parse(std::string_view text, const JsonLimits& limits) {
  Counter counter(limits);
  if (std::string problem = CountText(text, limits, counter); !problem.empty()) return Error{std::move(problem)};
  JsonDocument document;
  document.elements_.resize(counter.elements());
  document.members_.resize(counter.members());
  document.text_.resize(counter.text_bytes());
  Builder builder(counter.sizes(), document.elements_.data(), document.members_.data(), document.text_.data());
  if (std::string problem = Run(text, limits, builder); !problem.empty()) return Error{std::move(problem)};
  return document;
}

Status CheckJson(std::string_view text, const JsonLimits& limits) {
  Counter counter(limits);
  if (std::string problem = CountText(text, limits, counter); !problem.empty()) return Error{std::move(problem)};
  return Ok{};
}

using nlohmann::json;

json ParseJsonOrNull(const std::string& text) {
  return CheckJson(text, JsonLimits{}).ok() ? json::parse(text) : json();
}

const json* ValueAt(const json& document, const char* pointer) {
  const json::json_pointer at(pointer);
  return document.contains(at) ? &document.at(at) : nullptr;
}

double NumberAt(const json& document, const char* pointer) {
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_number() ? value->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

bool TrueAt(const json& document, const char* pointer) {
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_boolean() && value->get<bool>();
}

std::string StringAt(const json& document, const char* pointer) {
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

const json& ArrayAt(const json& document, const char* pointer) {
  static const json empty = json::array();
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_array() ? *value : empty;
}

}  // namespace omni::base
