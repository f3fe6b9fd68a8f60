// Result<T>: a value, or an Error that a person can act on. Used at set-up; the tick returns status instead.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace omni::base {

// `message` names the file, the JSON pointer or field, the limit, and what to do.
struct Error {
  std::string message;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : held_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : held_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return std::holds_alternative<T>(held_); }
  explicit operator bool() const { return ok(); }

  // Precondition: ok().
  T& value() { return std::get<T>(held_); }
  const T& value() const { return std::get<T>(held_); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }

  // Precondition: !ok().
  const std::string& error() const { return std::get<Error>(held_).message; }

 private:
  std::variant<T, Error> held_;
};

// Success carries nothing.
struct Ok {};
using Status = Result<Ok>;

}  // namespace omni::base
