// The layer's own events, until xrPollEvent. Bounded: if an application never polls, the oldest are lost and reported
// by XrEventDataEventsLost, as in a runtime.
#pragma once

#include <cstdint>
#include <cstring>
#include <deque>
#include <mutex>
#include <type_traits>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

class EventQueue {
 public:
  static constexpr std::size_t kMostWaiting = 256;

  // `Event`: an XrEventData* structure without a chain.
  template <class Event>
  void Push(const Event& event) {
    static_assert(std::is_trivially_copyable_v<Event> && sizeof(Event) <= sizeof(XrEventDataBuffer));
    XrEventDataBuffer buffer{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
    std::memcpy(&buffer, &event, sizeof(event));
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= kMostWaiting) {
      waiting_.pop_front();
      ++lost_;
    }
    waiting_.push_back(buffer);
  }

  // False: the queue is empty.
  bool Pop(XrEventDataBuffer& event) {
    const std::lock_guard lock(mutex_);
    if (lost_ > 0) {
      const XrEventDataEventsLost lost{XR_TYPE_EVENT_DATA_EVENTS_LOST, nullptr, lost_};
      std::memcpy(&event, &lost, sizeof(lost));
      lost_ = 0;
      return true;
    }
    if (waiting_.empty()) return false;
    event = waiting_.front();
    waiting_.pop_front();
    return true;
  }

 private:
  std::mutex mutex_;
  std::deque<XrEventDataBuffer> waiting_;
  std::uint32_t lost_ = 0;
};

}  // namespace omni::layer
