// Number of members of an aggregate at compile time, to check tables that must have a row for each.
#pragma once

#include <cstddef>

namespace omni::base {

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

}  // namespace omni::base
