// Tables of the numbers that a structure has: key, unit, range and member in one constexpr row. What reads, checks,
// prints or documents the structure goes through its table.
#pragma once

#include <cstddef>
#include <string_view>
#include <type_traits>

namespace omni::base {

// Number of members of an aggregate at compile time, to check tables that must have a row for each.
namespace aggregate {
struct Anything {
  template <class T>
  operator T() const;  // NOLINT(google-explicit-constructor): declared for unevaluated use only
};
}  // namespace aggregate

template <class T, class... Given>
consteval std::size_t FieldCount() {
  if constexpr (requires { T{Given{}..., aggregate::Anything{}}; }) {
    return FieldCount<T, Given..., aggregate::Anything>();
  } else {
    return sizeof...(Given);
  }
}

// Access to a number in a T. A count is stored as an int and accessed as a double.
template <class T>
struct NumberMember {
  double (*get)(const T&) noexcept;
  void (*set)(T&, double) noexcept;
  bool whole;
};

template <class T>
struct MemberOf;
template <class T, class Value>
struct MemberOf<Value T::*> {
  using Object = T;
  using Number = Value;
};

// A member, or a member of a member: AccessMember<&Material::softness, &Softness::thickness_m>().
template <auto kFirst, auto... kMore>
constexpr auto AccessMember() {
  using Object = typename MemberOf<decltype(kFirst)>::Object;
  using Number = typename MemberOf<decltype((kFirst, ..., kMore))>::Number;  // of the last
  return NumberMember<Object>{
      [](const Object& object) noexcept { return static_cast<double>(((object.*kFirst).*....*kMore)); },
      [](Object& object, double value) noexcept { ((object.*kFirst).*....*kMore) = static_cast<Number>(value); },
      std::is_integral_v<Number>};
}

template <class T>
struct NumberField {
  std::string_view key;   // path: "softness.thickness"
  std::string_view unit;  // "1": none
  double minimum, maximum;
  NumberMember<T> member;
  std::string_view about;  // for people, may be empty

  double Get(const T& object) const noexcept { return member.get(object); }
  void Set(T& object, double value) const noexcept { member.set(object, value); }
  double Default() const noexcept { return Get(T{}); }
  bool Contains(double value) const noexcept { return value >= minimum && value <= maximum; }
  // The part of the key before its last dot; may be empty.
  constexpr std::string_view Group() const noexcept {
    const std::size_t dot = key.rfind('.');
    return dot == std::string_view::npos ? std::string_view() : key.substr(0, dot);
  }
};

// Index of a key in a table of NumberField; the table's size if it is missing.
template <class Fields>
constexpr std::size_t IndexOfKey(const Fields& fields, std::string_view key) {
  std::size_t i = 0;
  while (i < fields.size() && fields[i].key != key) ++i;
  return i;
}

}  // namespace omni::base
