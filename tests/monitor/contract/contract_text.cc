#include "tests/monitor/contract/contract_text.h"

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "service/monitor/page/bit_names.h"
#include "service/monitor/page/page_layout.h"
#include "service/monitor/page/page_text.h"

namespace omni::monitor {
namespace {

using Json = nlohmann::ordered_json;

// Element and number of elements of what a message holds.
template <class T>
struct Element {
  using Type = T;
  static constexpr std::size_t kCount = 1;
};
template <class T, std::size_t N>
struct Element<std::array<T, N>> {
  using Type = T;
  static constexpr std::size_t kCount = N;
};
template <class T>
constexpr const char* NameOf() {
  if constexpr (std::is_same_v<T, double>) return "f64";
  if constexpr (std::is_same_v<T, float>) return "f32";
  if constexpr (std::is_same_v<T, std::uint32_t>) return "u32";
  if constexpr (std::is_same_v<T, std::uint16_t>) return "u16";
  if constexpr (sizeof(T) == 1) return "u8";
}

// Lists the fields that page_layout.h writes: {name, at, type}, where `at` is the offset in the message or in what the
// field is part of. A field of several numbers has their `count`; one with a length that differs has `length`, the
// product of which is the number of elements (none: to the end), and no `at` if such a field is before it.
class Fields {
 public:
  template <class T>
  void Put(const char* name, const T&) {
    Json row{{"name", name}, {"at", at_}, {"type", NameOf<typename Element<T>::Type>()}};
    if (Element<T>::kCount > 1) row["count"] = Element<T>::kCount;
    rows_.push_back(row);
    at_ += sizeof(T);
  }
  template <class T>
  void PutAll(const char* name, std::initializer_list<const char*> lengths, std::span<const T>) {
    Json row{{"name", name}, {"at", at_}, {"type", NameOf<typename Element<T>::Type>()}, {"length", Json(lengths)}};
    if (variable_) row.erase("at");
    if (Element<T>::kCount > 1) row["length"].push_back(Element<T>::kCount);
    variable_ = true;
    rows_.push_back(row);
  }
  template <class F>
  void Object(const char* name, const F& put) {
    const auto [fields, size] = Inner(put);
    rows_.push_back({{"name", name}, {"at", at_}, {"size", size}, {"fields", fields}});
    at_ += size;
  }
  template <class T, std::size_t N, class F>
  void Each(const char* name, std::span<const T, N> values, const F& put) {
    const auto [fields, size] = Inner([&] { put(values[0]); });
    rows_.push_back({{"name", name}, {"at", at_}, {"size", size}, {"count", N}, {"fields", fields}});
    at_ += N * size;
  }
  const Json& rows() const { return rows_; }

 private:
  template <class F>
  std::pair<Json, std::size_t> Inner(const F& put) {
    Json outer = std::exchange(rows_, Json::array());
    const std::size_t at = std::exchange(at_, 0);
    put();
    std::swap(rows_, outer);
    return {outer, std::exchange(at_, at)};
  }

  Json rows_ = Json::array();
  std::size_t at_ = 0;
  bool variable_ = false;
};

template <class F>
Json Message(PageMessage kind, const char* from, const F& put) {
  Fields fields;
  put(fields);
  return {{"kind", static_cast<int>(kind)}, {"from", from}, {"fields", fields.rows()}};
}

Json Messages() {
  return {
      {"live", Message(PageMessage::kLive, "server", [](Fields& out) { PutLive(out, {}); })},
      {"shape", Message(PageMessage::kShape, "server", [](Fields& out) { PutShape(out, 0, 0, {}); })},
      {"surface", Message(PageMessage::kSurface, "server", [](Fields& out) { PutSurface(out, 0, 0, {}, {}, {}); })},
      {"file", Message(PageMessage::kFile, "server", [](Fields& out) { PutFile(out, 0, "", ""); })},
      {"drop", Message(PageMessage::kDrop, "page", [](Fields& out) { PutDrop(out, "", ""); })},
  };
}

Json Bits(std::span<const BitName> names) {
  Json rows = Json::array();
  for (const BitName& row : names) {
    rows.push_back({{"bit", std::countr_zero(row.mask)}, {"name", row.name}, {"text", row.text}});
  }
  return rows;
}

Json Contract() {
  const Json hello = Json::parse(HelloText({}));
  return {{"magic", kPageMagic},
          {"version", kPageVersion},
          {"channels", hello["channels"]},
          {"flags", hello["flags"]},
          {"tick_faults", Bits(TickFaultNames())},
          {"tool_limits", Bits(ToolLimitNames())},
          {"device_faults", hello["device_faults"]},
          {"messages", Messages()}};
}

// A line for each row.
std::string Lines(const Json& json, const std::string& indent) {
  if (!json.is_structured() || json.contains("name")) return json.dump();
  std::string text;
  for (const auto& [key, value] : json.items()) {
    text += (text.empty() ? "\n " : ",\n ") + indent + (json.is_object() ? Json(key).dump() + ": " : "");
    text += Lines(value, indent + " ");
  }
  return json.is_object() ? "{" + text + "\n" + indent + "}" : "[" + text + "\n" + indent + "]";
}

// A row as decode.ts reads it: 'u32', ['f32', 3], {fields}, [4, {fields}].
std::string Layout(const Json& row, const std::string& indent) {
  if (!row.contains("fields")) {
    std::string text = "'" + row["type"].get<std::string>() + "'";
    if (row.contains("count")) return "[" + text + ", " + row["count"].dump() + "]";
    for (const Json& length : row.value("length", Json::array())) {
      text += ", " + (length.is_string() ? "'" + length.get<std::string>() + "'" : length.dump());
    }
    return row.contains("length") ? "[" + text + "]" : text;
  }
  std::string text = "{\n";
  for (const Json& field : row["fields"]) {
    text += indent + "  " + field["name"].get<std::string>() + ": " + Layout(field, indent + "  ") + ",\n";
  }
  text += indent + "}";
  return row.contains("count") ? "[" + row["count"].dump() + ", " + text + "]" : text;
}

std::string Union(const std::string& type, const Json& rows) {
  std::string text = "export type " + type + " =";
  for (const Json& row : rows) text += "\n  | '" + row["name"].get<std::string>() + "'";
  return text + ";\n";
}

std::string Masks(const std::string& constant, const Json& rows) {
  std::string text = "export const " + constant + " = {\n";
  for (const Json& row : rows) {
    text += "  " + row["name"].get<std::string>() + ": " + std::to_string(1U << row["bit"].get<unsigned>()) + ",\n";
  }
  return text + "} as const;\n";
}

}  // namespace

std::string ContractTypes() {
  const Json contract = Contract();
  Fields head;
  PutHead(head, PageMessage::kLive);
  std::string kinds, layouts = "  head: " + Layout({{"fields", head.rows()}}, "  ") + ",\n";
  for (const auto& [name, message] : contract["messages"].items()) {
    kinds += "  " + name + ": " + message["kind"].dump() + ",\n";
    layouts += "  " + name + ": " + Layout(message, "  ") + ",\n";
  }
  return "// Printed by build/release/bin/page_contract from the service's tables (service/monitor/page/channels.cc,\n"
         "// bit_names.cc, page_layout.h, firmware/wire/names.cc); the test PageContract.IsUpToDate compares. A name "
         "that\n"
         "// is not here is an error of the compiler.\n" +
         Union("ChannelName", contract["channels"]) + Union("FlagName", contract["flags"]) +
         "// Of the channel \"tick_faults\".\n" + Masks("kTickFault", contract["tick_faults"]) +
         "// Of the channel \"tool_limits\".\n" + Masks("kToolLimit", contract["tool_limits"]) +
         "// Of the channel \"device_faults\".\n" + Union("DeviceFaultName", contract["device_faults"]) +
         "// Binary messages, field after field: a number; an array [element, number of elements: the product of what\n"
         "// follows, none: to the end]; an object; objects [how many, object].\n"
         "export const kMagic = " +
         contract["magic"].dump() + ";\nexport const kKind = {\n" + kinds + "} as const;\nexport const kLayout = {\n" +
         layouts + "} as const;\n";
}

std::string ContractJson() { return Lines(Contract(), "") + "\n"; }

}  // namespace omni::monitor
