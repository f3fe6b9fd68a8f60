// The part of GoogleTest that tests of firmware use, for a target without files, threads, exceptions and RTTI: the same
// test sources run on the host against the real one and on the emulated Cortex-M7 against this. Failures are printed
// and counted; tests/target/main.cc runs what is registered.
#pragma once
#pragma GCC system_header  // as the real one is: comparisons of signed and unsigned within it stay silent

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace testing {

class Test {
 public:
  virtual ~Test() = default;
  virtual void SetUp() {}
  virtual void TearDown() {}
  virtual void TestBody() = 0;
  static bool HasFatalFailure() { return fatal; }
  static bool HasFailure() { return failures_of_this_test > 0; }
  static void RecordProperty(const std::string&, const std::string&) {}  // no report is written here

  static inline bool fatal = false;
  static inline int failures_of_this_test = 0;
};

template <class Param>
class TestWithParam : public Test {
 public:
  using ParamType = Param;
  static const Param& GetParam() { return *param; }
  static inline const Param* param = nullptr;
};

template <class Param>
struct TestParamInfo {
  Param param;
  std::size_t index;
};

class Message {
 public:
  template <class Value>
  Message& operator<<(const Value& value) {
    out_ << value;
    return *this;
  }
  std::string str() const { return out_.str(); }
  friend std::ostream& operator<<(std::ostream& out, const Message& message) { return out << message.str(); }

 private:
  std::ostringstream out_;
};

namespace internal {

// A test to run; with parameters one for each of them.
struct Registered {
  const char* suite;
  std::string name;
  std::function<Test*()> make;
  const char* written;  // the same for all parameters
};
inline std::vector<Registered>& Tests() {
  static std::vector<Registered> tests;
  return tests;
}

struct Registration {
  Registration(const char* suite, const char* name, Test* (*make)()) { Tests().push_back({suite, name, make, name}); }
};

// TEST_P and INSTANTIATE_TEST_SUITE_P of a suite, in whatever order they come; tests/target/main.cc brings them
// together.
inline std::vector<void (*)()>& Expansions() {
  static std::vector<void (*)()> expansions;
  return expansions;
}

template <class Suite>
struct Parameters {
  using Param = typename Suite::ParamType;
  struct Written {
    const char* suite;
    const char* name;
    Test* (*make)();
  };
  struct Value {
    std::string name;
    Param value;
  };
  static inline std::vector<Written> tests;
  static inline std::vector<Value> values;

  static void Expand() {
    for (const Written& test : tests) {
      for (const Value& value : values) {
        const auto make = [&test, &value]() -> Test* {
          TestWithParam<Param>::param = &value.value;
          return test.make();
        };
        Tests().push_back({test.suite, std::string(test.name) + "/" + value.name, make, test.name});
      }
    }
  }
};

template <class Suite>
struct ParameterRegistration {
  ParameterRegistration(const char* suite, const char* name, Test* (*make)()) {
    if (Parameters<Suite>::tests.empty()) Expansions().push_back(Parameters<Suite>::Expand);
    Parameters<Suite>::tests.push_back({suite, name, make});
  }
};

template <class Suite>
struct Instantiation {
  using Param = typename Suite::ParamType;
  template <class Values>
  explicit Instantiation(const Values& values) {
    Add(values, [](const TestParamInfo<Param>& info) { return std::to_string(info.index); });
  }
  template <class Values, class Name>
  Instantiation(const Values& values, const Name& name) {
    Add(values, name);
  }

 private:
  template <class Values, class Name>
  void Add(const Values& values, const Name& name) {
    std::size_t index = 0;
    for (const auto& value : values) {
      Parameters<Suite>::values.push_back({name(TestParamInfo<Param>{Param(value), index}), Param(value)});
      ++index;
    }
  }
};

// Prints one line; tests/target/main.cc has it.
void Report(const char* file, int line, const std::string& text);

// Texts of SCOPED_TRACE that are in force.
struct Trace {
  template <class Value>
  Trace(const char* file, int line, const Value& value) : outer(innermost) {
    std::ostringstream out;
    out << file << ":" << line << ": " << value;
    text = out.str();
    innermost = this;
  }
  ~Trace() { innermost = outer; }
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  std::string text;
  const Trace* outer;
  static inline const Trace* innermost = nullptr;
};

template <class Value>
void PrintValue(std::ostream& out, const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    out << static_cast<long long>(value);
  } else if constexpr (std::is_same_v<Value, char> || std::is_same_v<Value, signed char> ||
                       std::is_same_v<Value, unsigned char>) {
    out << static_cast<int>(value);
  } else if constexpr (std::is_floating_point_v<Value>) {
    out.precision(std::numeric_limits<Value>::max_digits10);
    out << value;
  } else if constexpr (requires { out << value; }) {
    out << value;
  } else {
    out << "(" << sizeof(Value) << " bytes)";
  }
}

// "return Failure(...) = Message() << ..." ends the test's function, which returns nothing.
class Failure {
 public:
  Failure(const char* file, int line, std::string what, bool is_fatal)
      : file_(file), line_(line), what_(std::move(what)) {
    ++Test::failures_of_this_test;
    Test::fatal = Test::fatal || is_fatal;
  }
  void operator=(const Message& message) const {
    std::string text = what_;
    if (!message.str().empty()) text += "\n  " + message.str();
    for (const Trace* trace = Trace::innermost; trace != nullptr; trace = trace->outer) text += "\n  " + trace->text;
    Report(file_, line_, text);
  }

 private:
  const char* file_;
  int line_;
  std::string what_;
};

// Empty: it holds.
class Outcome {
 public:
  Outcome() = default;
  explicit Outcome(std::string what) : holds_(false), what_(std::move(what)) {}
  explicit operator bool() const { return holds_; }
  const std::string& what() const { return what_; }

 private:
  bool holds_ = true;
  std::string what_;
};

template <class A, class B>
Outcome Says(const char* a_text, const char* relation, const char* b_text, const A& a, const B& b) {
  std::ostringstream out;
  out << a_text << " " << relation << " " << b_text << " does not hold: ";
  PrintValue(out, a);
  out << " and ";
  PrintValue(out, b);
  return Outcome(out.str());
}

#define OMNI_TARGET_RELATION(Name, relation)                                     \
  template <class A, class B>                                                    \
  Outcome Name(const char* a_text, const char* b_text, const A& a, const B& b) { \
    return (a relation b) ? Outcome() : Says(a_text, #relation, b_text, a, b);   \
  }
OMNI_TARGET_RELATION(Eq, ==)
OMNI_TARGET_RELATION(Ne, !=)
OMNI_TARGET_RELATION(Lt, <)
OMNI_TARGET_RELATION(Le, <=)
OMNI_TARGET_RELATION(Gt, >)
OMNI_TARGET_RELATION(Ge, >=)
#undef OMNI_TARGET_RELATION

inline Outcome StrEq(const char* a_text, const char* b_text, const std::string& a, const std::string& b) {
  return a == b ? Outcome() : Says(a_text, "is the text", b_text, a, b);
}
inline Outcome StrNe(const char* a_text, const char* b_text, const std::string& a, const std::string& b) {
  return a != b ? Outcome() : Says(a_text, "is not the text", b_text, a, b);
}
inline Outcome Near(const char* a_text, const char* b_text, double a, double b, double within) {
  return std::fabs(a - b) <= within ? Outcome() : Says(a_text, "is near", b_text, a, b);
}
// Within four units in the last place, as GoogleTest has it.
template <class Float>
Outcome FloatEq(const char* a_text, const char* b_text, Float a, Float b) {
  const Float scale = std::fmax(std::fabs(a), std::fabs(b));
  const Float within = 4 * (std::nextafter(scale, std::numeric_limits<Float>::infinity()) - scale);
  return a == b || std::fabs(a - b) <= within ? Outcome() : Says(a_text, "is about", b_text, a, b);
}
inline Outcome Is(const char* text, bool value, bool expected) {
  return value == expected ? Outcome() : Outcome(std::string(text) + (expected ? " is false" : " is true"));
}

}  // namespace internal
}  // namespace testing

namespace testing {

template <class Container>
std::vector<typename Container::value_type> ValuesIn(const Container& values) {
  return {values.begin(), values.end()};
}
template <class Value, std::size_t count>
std::vector<Value> ValuesIn(const Value (&values)[count]) {
  return {values, values + count};
}
template <class Value, class... More>
std::vector<std::common_type_t<Value, More...>> Values(Value value, More... more) {
  return {value, more...};
}
inline std::vector<bool> Bool() { return {false, true}; }
template <class Value>
std::vector<Value> Range(Value begin, Value end) {
  std::vector<Value> values;
  for (Value value = begin; value < end; ++value) values.push_back(value);
  return values;
}

}  // namespace testing

#define OMNI_TARGET_TEST(suite, name, base, registration)                                                            \
  class suite##_##name : public base {                                                                               \
   public:                                                                                                           \
    void TestBody() override;                                                                                        \
    static ::testing::Test* Make() { return new suite##_##name; }                                                    \
  };                                                                                                                 \
  static const ::testing::internal::registration registration_##suite##_##name(#suite, #name, suite##_##name::Make); \
  void suite##_##name::TestBody()

#define TEST(suite, name) OMNI_TARGET_TEST(suite, name, ::testing::Test, Registration)
#define TEST_F(fixture, name) OMNI_TARGET_TEST(fixture, name, fixture, Registration)
#define TEST_P(fixture, name) OMNI_TARGET_TEST(fixture, name, fixture, ParameterRegistration<fixture>)
#define INSTANTIATE_TEST_SUITE_P(prefix, suite, ...) \
  static const ::testing::internal::Instantiation<suite> instantiation_##prefix##_##suite(__VA_ARGS__)

// The switch keeps an else after it from being ours.
#define OMNI_TARGET_EXPECT(outcome)                                    \
  switch (0)                                                           \
  case 0:                                                              \
  default:                                                             \
    if (const ::testing::internal::Outcome omni_outcome = (outcome)) { \
    } else                                                             \
      ::testing::internal::Failure(__FILE__, __LINE__, omni_outcome.what(), false) = ::testing::Message()
#define OMNI_TARGET_ASSERT(outcome)                                    \
  switch (0)                                                           \
  case 0:                                                              \
  default:                                                             \
    if (const ::testing::internal::Outcome omni_outcome = (outcome)) { \
    } else                                                             \
      return ::testing::internal::Failure(__FILE__, __LINE__, omni_outcome.what(), true) = ::testing::Message()

#define EXPECT_EQ(a, b) OMNI_TARGET_EXPECT(::testing::internal::Eq(#a, #b, a, b))
#define EXPECT_NE(a, b) OMNI_TARGET_EXPECT(::testing::internal::Ne(#a, #b, a, b))
#define EXPECT_LT(a, b) OMNI_TARGET_EXPECT(::testing::internal::Lt(#a, #b, a, b))
#define EXPECT_LE(a, b) OMNI_TARGET_EXPECT(::testing::internal::Le(#a, #b, a, b))
#define EXPECT_GT(a, b) OMNI_TARGET_EXPECT(::testing::internal::Gt(#a, #b, a, b))
#define EXPECT_GE(a, b) OMNI_TARGET_EXPECT(::testing::internal::Ge(#a, #b, a, b))
#define EXPECT_STREQ(a, b) OMNI_TARGET_EXPECT(::testing::internal::StrEq(#a, #b, a, b))
#define EXPECT_STRNE(a, b) OMNI_TARGET_EXPECT(::testing::internal::StrNe(#a, #b, a, b))
#define EXPECT_TRUE(a) OMNI_TARGET_EXPECT(::testing::internal::Is(#a, static_cast<bool>(a), true))
#define EXPECT_FALSE(a) OMNI_TARGET_EXPECT(::testing::internal::Is(#a, static_cast<bool>(a), false))
#define EXPECT_NEAR(a, b, within) OMNI_TARGET_EXPECT(::testing::internal::Near(#a, #b, a, b, within))
#define EXPECT_FLOAT_EQ(a, b) OMNI_TARGET_EXPECT(::testing::internal::FloatEq<float>(#a, #b, a, b))
#define EXPECT_DOUBLE_EQ(a, b) OMNI_TARGET_EXPECT(::testing::internal::FloatEq<double>(#a, #b, a, b))
#define ASSERT_EQ(a, b) OMNI_TARGET_ASSERT(::testing::internal::Eq(#a, #b, a, b))
#define ASSERT_NE(a, b) OMNI_TARGET_ASSERT(::testing::internal::Ne(#a, #b, a, b))
#define ASSERT_LT(a, b) OMNI_TARGET_ASSERT(::testing::internal::Lt(#a, #b, a, b))
#define ASSERT_LE(a, b) OMNI_TARGET_ASSERT(::testing::internal::Le(#a, #b, a, b))
#define ASSERT_GT(a, b) OMNI_TARGET_ASSERT(::testing::internal::Gt(#a, #b, a, b))
#define ASSERT_GE(a, b) OMNI_TARGET_ASSERT(::testing::internal::Ge(#a, #b, a, b))
#define ASSERT_STREQ(a, b) OMNI_TARGET_ASSERT(::testing::internal::StrEq(#a, #b, a, b))
#define ASSERT_TRUE(a) OMNI_TARGET_ASSERT(::testing::internal::Is(#a, static_cast<bool>(a), true))
#define ASSERT_FALSE(a) OMNI_TARGET_ASSERT(::testing::internal::Is(#a, static_cast<bool>(a), false))
#define ASSERT_NEAR(a, b, within) OMNI_TARGET_ASSERT(::testing::internal::Near(#a, #b, a, b, within))
#define ADD_FAILURE() OMNI_TARGET_EXPECT(::testing::internal::Outcome("failed"))
#define FAIL() OMNI_TARGET_ASSERT(::testing::internal::Outcome("failed"))
#define SUCCEED() ::testing::Message()
#define OMNI_TARGET_JOIN(a, b) a##b
#define OMNI_TARGET_NAME(a, b) OMNI_TARGET_JOIN(a, b)
#define SCOPED_TRACE(value) \
  const ::testing::internal::Trace OMNI_TARGET_NAME(omni_trace_, __LINE__)(__FILE__, __LINE__, value)
