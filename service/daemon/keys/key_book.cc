#include "service/daemon/keys/key_book.h"

#include <algorithm>
#include <cstring>

namespace omni::daemon {
namespace {

constexpr std::int64_t kOldestEvent_ns = 1'000'000'000;

std::int64_t StampOf(const input_event& event, std::int64_t now_ns) {
  const auto seconds = static_cast<std::int64_t>(event.input_event_sec);
  const auto microseconds = static_cast<std::int64_t>(event.input_event_usec);
  const bool sane = seconds >= 0 && seconds <= now_ns / 1'000'000'000 && microseconds >= 0 && microseconds < 1'000'000;
  if (!sane) return now_ns;
  const std::int64_t t_ns = seconds * 1'000'000'000 + microseconds * 1000;
  return t_ns <= now_ns && t_ns >= now_ns - kOldestEvent_ns ? t_ns : now_ns;
}

}  // namespace

bool KeyBook::SetSlot(int device, std::size_t slot, bool down, std::int64_t t_ns) {
  const std::uint32_t bit = std::uint32_t{1} << device;
  const std::uint32_t before = holders_[slot];
  const std::uint32_t after = down ? before | bit : before & ~bit;
  holders_[slot] = after;
  if ((before == 0) == (after == 0)) return false;
  base::KeyState& key = states_.slots[slot];
  if (down) {
    ++key.press_count;
    key.t_press_ns = std::max(t_ns, key.t_release_ns);
  } else {
    ++key.release_count;
    key.t_release_ns = std::max(t_ns, key.t_press_ns);
  }
  return true;
}

bool KeyBook::Set(int device, std::uint16_t code, bool down, std::int64_t t_ns) {
  const auto found = std::find(codes_.begin(), codes_.end(), code);
  return found != codes_.end() && SetSlot(device, static_cast<std::size_t>(found - codes_.begin()), down, t_ns);
}

bool KeyBook::ReleaseAll(int device, std::int64_t t_ns) {
  bool changed = false;
  for (std::size_t slot = 0; slot < codes_.size(); ++slot) changed = SetSlot(device, slot, false, t_ns) || changed;
  return changed;
}

void KeyDecoder::Feed(const unsigned char* bytes, std::size_t count, std::int64_t now_ns, const Emit& emit) {
  while (count > 0) {
    const std::size_t taken = std::min(count, partial_.size() - partial_bytes_);
    std::memcpy(partial_.data() + partial_bytes_, bytes, taken);
    partial_bytes_ += taken;
    bytes += taken;
    count -= taken;
    if (partial_bytes_ < partial_.size()) return;
    partial_bytes_ = 0;
    input_event event;
    std::memcpy(&event, partial_.data(), sizeof(event));
    Take(event, now_ns, emit);
  }
}

void KeyDecoder::Take(const input_event& event, std::int64_t now_ns, const Emit& emit) {
  if (event.type == EV_SYN && event.code == SYN_DROPPED) {
    skipping_ = true;
    dropped_ = true;
  } else if (event.type == EV_SYN && event.code == SYN_REPORT) {
    skipping_ = false;
  } else if (event.type == EV_KEY && !skipping_ && event.code <= KEY_MAX && (event.value == 0 || event.value == 1)) {
    emit(event.code, event.value == 1, StampOf(event, now_ns));  // 2 is a key that repeats itself
  }
}

bool KeyDecoder::PopDropped() {
  if (skipping_) return false;  // the end of the report comes first
  const bool dropped = dropped_;
  dropped_ = false;
  return dropped;
}

}  // namespace omni::daemon
