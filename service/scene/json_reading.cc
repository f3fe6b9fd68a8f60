#include "service/scene/json_reading.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "service/scene/load_error.h"

namespace omni::scene {
namespace {

// Nesting of brackets outside strings: one pass, no recursion.
void CheckDepth(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        in_string = false;
      }
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth) {
        throw LoadError("", "JSON is nested deeper than " + std::to_string(kMaxJsonDepth) + " levels at byte " +
                                std::to_string(i) + "; no glTF needs that, the file is refused");
      }
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

}  // namespace

std::string Shown(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

Json ParseJson(std::string_view text) {
  CheckDepth(text);
  std::vector<std::set<std::string>> keys;  // of every object that is open
  const auto callback = [&keys](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) {
      keys.emplace_back();
    } else if (event == Json::parse_event_t::object_end) {
      keys.pop_back();
    } else if (event == Json::parse_event_t::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!keys.back().insert(key).second) {
        throw LoadError("", "JSON key \"" + key + "\" is there twice in one object; keep one of them");
      }
    }
    return true;
  };
  Json root;
  try {
    root = Json::parse(text.begin(), text.end(), callback);
  } catch (const Json::exception& error) {
    throw LoadError("", std::string("JSON cannot be parsed: ") + error.what());
  }
  if (!root.is_object()) throw LoadError("", "JSON root must be an object; this is no glTF document");
  return root;
}

std::string Join(const std::string& pointer, std::string_view key) {
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

std::string Join(const std::string& pointer, std::uint64_t index) { return pointer + "/" + std::to_string(index); }

const Json* Find(const Json& parent, const char* key) {
  if (!parent.is_object()) return nullptr;
  const auto found = parent.find(key);
  return found == parent.end() ? nullptr : &*found;
}

const Json* FindObject(const Json& parent, const std::string& pointer, const char* key) {
  const Json* found = Find(parent, key);
  if (found && !found->is_object()) throw LoadError(Join(pointer, key), "is " + Shown(*found) + ", must be an object");
  return found;
}

const Json* FindArray(const Json& parent, const std::string& pointer, const char* key) {
  const Json* found = Find(parent, key);
  if (found && !found->is_array()) throw LoadError(Join(pointer, key), "is " + Shown(*found) + ", must be an array");
  return found;
}

std::string FindString(const Json& parent, const std::string& pointer, const char* key, const std::string& fallback) {
  const Json* found = Find(parent, key);
  if (!found) return fallback;
  if (!found->is_string()) throw LoadError(Join(pointer, key), "is " + Shown(*found) + ", must be a string");
  return found->get<std::string>();
}

std::uint64_t CountOf(const Json& root, const char* key) {
  const Json* array = FindArray(root, "", key);
  return array ? array->size() : 0;
}

const Json& ElementOf(const Json& root, const char* key, std::uint64_t index) {
  const std::string pointer = Join(Join("", key), index);
  const Json* array = FindArray(root, "", key);
  if (!array || index >= array->size()) throw LoadError(pointer, "does not exist");
  const Json& element = (*array)[static_cast<std::size_t>(index)];
  if (!element.is_object()) throw LoadError(pointer, "is " + Shown(element) + ", must be an object");
  return element;
}

std::uint64_t Whole(const Json& parent, const std::string& pointer, const char* key, std::uint64_t maximum,
                    std::optional<std::uint64_t> fallback) {
  const Json* found = Find(parent, key);
  if (!found && fallback) return *fallback;
  if (!found) throw LoadError(Join(pointer, key), "is missing");
  // The parser stores what is not negative as unsigned; 2.0 and -1 are refused here.
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() > maximum) {
    throw LoadError(Join(pointer, key),
                    "is " + Shown(*found) + ", must be a whole number from 0 to " + std::to_string(maximum));
  }
  return found->get<std::uint64_t>();
}

std::optional<std::uint32_t> Index(const Json& parent, const std::string& pointer, const char* key,
                                   std::uint64_t count) {
  const Json* found = Find(parent, key);
  if (!found) return std::nullopt;
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() >= count ||
      found->get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
    throw LoadError(Join(pointer, key), "is " + Shown(*found) + ", must be an index below " + std::to_string(count));
  }
  return static_cast<std::uint32_t>(found->get<std::uint64_t>());
}

std::vector<double> Numbers(const Json& parent, const std::string& pointer, const char* key, std::size_t count) {
  const Json* found = FindArray(parent, pointer, key);
  if (!found) return {};
  if (found->size() != count) {
    throw LoadError(Join(pointer, key),
                    "has " + std::to_string(found->size()) + " elements, must have " + std::to_string(count));
  }
  std::vector<double> numbers;
  for (const Json& element : *found) {
    const double number = element.is_number() ? element.get<double>() : std::nan("");
    if (!(std::abs(number) <= 1e12)) {
      throw LoadError(Join(Join(pointer, key), numbers.size()),
                      "is " + Shown(element) + ", must be a number within +-1e12");
    }
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace omni::scene
