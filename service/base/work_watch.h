// Long work that can be ended from outside. It says what it does, in units of less than a microsecond or so (a triangle
// read, a node visited, a KiB copied); every thousand of them the watch asks whether to go on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <functional>
#include <utility>

namespace omni::base {

// Thrown out of the work; functions that return a Result make it an Error with these words.
struct Cancelled : std::exception {
  static constexpr const char* kWords = "cancelled";
  const char* what() const noexcept override { return kWords; }
};

// Of one thread. Const for those who work: what they do does not depend on it.
class WorkWatch {
 public:
  static constexpr std::uint64_t kEvery = 1000;

  WorkWatch() = default;  // never ends the work
  // `stop` returns true to end it; cheap, because it is called often.
  explicit WorkWatch(std::function<bool()> stop) : stop_(std::move(stop)) {}

  // Throws Cancelled.
  void Did(std::uint64_t units = 1) const {
    since_ += units;
    if (since_ >= kEvery) Ask();
  }
  // At the end of a step after which something would be left behind. Throws Cancelled.
  void Ask() const {
    done_ += since_;
    longest_ = std::max(longest_, since_);
    since_ = 0;
    if (stop_ && stop_()) throw Cancelled();
  }

  std::uint64_t done() const { return done_ + since_; }
  std::uint64_t longest() const { return longest_; }  // most units between two questions

 private:
  std::function<bool()> stop_;
  mutable std::uint64_t since_ = 0, done_ = 0, longest_ = 0;
};

}  // namespace omni::base
