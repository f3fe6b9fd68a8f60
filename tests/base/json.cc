// JSON documents: accepted and rejected texts, and limits.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include <nlohmann/json.hpp>

#include "service/base/files/json_document.h"

namespace omni::base {
namespace test_base_json {

constexpr JsonLimits kWide{.bytes = 64u << 20, .values = 4'000'000, .members = 4'000'000, .depth = 128};

JsonDocument Parsed(const std::string& text, const JsonLimits& limits = kWide) {
  Result<JsonDocument> document = JsonDocument::Parse(text, limits);
  EXPECT_TRUE(document.ok()) << document.error();
  return document.ok() ? std::move(*document) : JsonDocument();
}

std::string Refusal(const std::string& text, const JsonLimits& limits = kWide) {
  const Result<JsonDocument> document = JsonDocument::Parse(text, limits);
  const Status checked = CheckJson(text, limits);
  const std::string refusal = document.ok() ? "read" : document.error();
  if (!checked.ok()) {
    EXPECT_EQ(checked.error(), refusal);
  }
  return refusal;
}

TEST(JsonDocument, ReadsEveryKindOfValue) {
  const JsonDocument document = Parsed(R"({"b": [true, false, null], "a": {"n": 7, "m": -7, "x": 7.0, "e": 1e3},
    "t": "A\u00e9\n\ud83d\ude00", "": [], "o": {}, "big": 18446744073709551615, "bigger": 18446744073709551616})");
  const JsonValue& root = document.root();
  ASSERT_TRUE(root.is_object());
  EXPECT_EQ(root.members().size(), 7U);
  EXPECT_EQ(root.Find("t")->text(), "A\xC3\xA9\n\xF0\x9F\x98\x80");
  const auto elements = root.Find("b")->elements();
  ASSERT_EQ(elements.size(), 3U);
  EXPECT_TRUE(elements[0].boolean());
  EXPECT_TRUE(elements[1].is_boolean() && !elements[1].boolean());
  EXPECT_TRUE(elements[2].is_null());
  const JsonValue& a = *root.Find("a");
  EXPECT_EQ(a.Find("n")->whole(), 7U);
  EXPECT_EQ(a.Find("n")->number(), 7);
  EXPECT_EQ(a.Find("m")->whole(), std::nullopt);
  EXPECT_EQ(a.Find("m")->number(), -7);
  EXPECT_EQ(a.Find("x")->whole(), std::nullopt);
  EXPECT_EQ(a.Find("e")->number(), 1000);
  EXPECT_TRUE(root.Find("")->is_array() && root.Find("")->elements().empty());
  EXPECT_TRUE(root.Find("o")->is_object() && root.Find("o")->members().empty());
  EXPECT_EQ(root.Find("big")->whole(), 18446744073709551615ULL);
  EXPECT_EQ(root.Find("bigger")->whole(), std::nullopt);
  EXPECT_EQ(root.Find("bigger")->number(), 18446744073709551616.0);
}

TEST(JsonDocument, AccessorsOfTheWrongKindReturnNothing) {
  const JsonDocument document = Parsed(R"({"text": "x", "list": [1]})");
  const JsonValue& text = *document.root().Find("text");
  EXPECT_TRUE(std::isnan(text.number()));
  EXPECT_EQ(text.whole(), std::nullopt);
  EXPECT_FALSE(text.boolean());
  EXPECT_TRUE(text.elements().empty() && text.members().empty());
  EXPECT_EQ(text.Find("x"), nullptr);
  EXPECT_EQ(document.root().Find("texts"), nullptr);
  EXPECT_EQ(document.root().text(), "");
  EXPECT_TRUE(JsonDocument().root().is_null());
}

TEST(JsonDocument, ErrorsNameTheExceededLimit) {
  EXPECT_EQ(Refusal("[1, 2, 3]", {.bytes = 8}), "has 9 bytes of JSON, the limit is 8");
  EXPECT_EQ(Refusal("[1, 2, 3]", {.values = 3}), "has more than 3 JSON values, the limit");
  EXPECT_EQ(Refusal("[1, 2, 3]", {.values = 4}), "read");
  EXPECT_EQ(Refusal("[[{}]]", {.depth = 2}), "JSON is nested deeper than 2 levels, the limit");
  EXPECT_EQ(Refusal("[[{}], [[]]]", {.depth = 3}), "read");
  EXPECT_EQ(Refusal(R"([{"a": 1, "b": 2}])", {.members = 1}), "has a JSON object of more than 1 members, the limit");
  EXPECT_EQ(Refusal(R"([{"a": [1, 2]}, {"b": 3}])", {.members = 1}), "read");
  EXPECT_EQ(Refusal(R"({"a": {"b": 1, "c": 2, "b": 3}})"),
            "JSON key \"b\" appears twice in one object; keep one of them");
  EXPECT_EQ(Refusal(R"([{"a": 1}, {"a": 2}])"), "read");
}

TEST(JsonDocument, RejectsBadTextWithShortPrintableError) {
  const std::string digits(1'000'000, '9');
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[1,]"), std::string("{\"a\" 1}"), std::string("[1] 2"),
        std::string("[1e999999]"), "[" + digits + "]", "[1e" + digits + "]", std::string("[\"\xFF\xFE\"]"),
        std::string("[\"\x1B[31m\"]"), std::string("[\"\\ud800\"]"), std::string("// comment\n[]"), "[\"" + digits,
        std::string("[\0]", 3), std::string("{'a': 1}")}) {
    const std::string refusal = Refusal(text);
    EXPECT_EQ(refusal.rfind("JSON cannot be parsed: ", 0), 0U) << refusal;
    EXPECT_LT(refusal.size(), 300U);
    EXPECT_EQ(refusal.find_first_of("\n\x1B\xFF"), std::string::npos) << refusal;
  }
  EXPECT_EQ(Refusal("\xEF\xBB\xBF[1]"), "read") << "a byte order mark";
}

// What nlohmann::json makes of a text, which refuses no key that appears twice: the last one holds.
bool Same(const JsonValue& value, const nlohmann::json& expected) {
  if (expected.is_object()) {
    if (value.members().size() != expected.size()) return false;
    for (const auto& [key, member] : expected.items()) {
      const JsonValue* found = value.Find(key);
      if (found == nullptr || !Same(*found, member)) return false;
    }
    return value.is_object();
  }
  if (expected.is_array()) {
    if (!value.is_array() || value.elements().size() != expected.size()) return false;
    for (std::size_t i = 0; i < expected.size(); ++i)
      if (!Same(value.elements()[i], expected[i])) return false;
    return true;
  }
  if (expected.is_string()) return value.is_text() && value.text() == expected.get<std::string>();
  if (expected.is_number_unsigned()) return value.whole() == expected.get<std::uint64_t>();
  if (expected.is_number()) return value.is_number() && !value.whole() && value.number() == expected.get<double>();
  if (expected.is_boolean()) return value.is_boolean() && value.boolean() == expected.get<bool>();
  return value.is_null();
}

class RandomText {
 public:
  explicit RandomText(std::uint32_t seed) : random_(seed) {}
  std::size_t Below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  std::string Value(int depth) {
    static const char* const kScalars[] = {"0",
                                           "-0",
                                           "17",
                                           "-3",
                                           "2.5e-3",
                                           "1E+2",
                                           "true",
                                           "false",
                                           "null",
                                           "\"\"",
                                           "\"a\\\"b\\u0041\"",
                                           "\"\xC3\xA9\"",
                                           "18446744073709551616",
                                           "[]",
                                           "{}"};
    if (depth == 0 || Below(3) == 0) return kScalars[Below(std::size(kScalars))];
    const bool object = Below(2) == 0;
    std::string text = object ? "{" : "[";
    for (std::size_t i = 0, n = Below(5); i < n; ++i) {
      if (i > 0) text += Below(4) == 0 ? " ,\n" : ",";
      if (object) text += "\"" + std::to_string(10 * i + Below(10)) + "\": ";
      text += Value(depth - 1);
    }
    return text + (object ? "}" : "]");
  }

  // A byte changed, cut out or doubled, up to three times; often none.
  std::string Damaged(std::string text) {
    for (std::size_t i = Below(4); i > 0 && !text.empty(); --i) {
      const std::size_t at = Below(text.size());
      constexpr char kBytes[] = "{}[],:\"\\eE+-.019 \x80\xFFu";
      switch (Below(4)) {
        case 0:
          text.erase(at, 1);
          break;
        case 1:
          text.insert(at, text.substr(Below(text.size()), 1 + Below(6)));
          break;
        case 2:
          text.resize(at);
          break;
        default:
          text[at] = kBytes[Below(sizeof kBytes - 1)];
      }
    }
    return text;
  }

 private:
  std::mt19937 random_;
};

// OMNI_FUZZ: how many texts.
TEST(JsonDocument, AgreesWithNlohmannJson) {
  const char* many = std::getenv("OMNI_FUZZ");
  const std::size_t count = many != nullptr ? std::stoul(many) : 20'000;
  RandomText random(4);
  std::size_t read = 0, twice = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string text = random.Damaged(random.Value(5));
    const nlohmann::json expected = nlohmann::json::parse(text, nullptr, false);
    const Result<JsonDocument> document = JsonDocument::Parse(text, kWide);
    ASSERT_EQ(CheckJson(text, kWide).ok(), !expected.is_discarded()) << text;
    if (!document.ok() && document.error().find("appears twice") != std::string::npos) {
      ++twice;
      continue;
    }
    ASSERT_EQ(document.ok(), !expected.is_discarded()) << text;
    if (!document.ok()) continue;
    ++read;
    ASSERT_TRUE(Same(document->root(), expected)) << text;
  }
  RecordProperty("texts", static_cast<int>(count));
  RecordProperty("read", static_cast<int>(read));
  EXPECT_GT(read, count / 4);
  EXPECT_LT(read + twice, count);
}

}  // namespace test_base_json
}  // namespace omni::base
