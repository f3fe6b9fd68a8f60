// A realistic USB host for tests: control and bulk transfers in packets, with data toggles, retries after NAK and
// time-outs. Between tokens the device gets its interrupt, unless it is delayed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "tests/support/chips/chipidea_model.h"

namespace omni::support {

struct UsbRequest {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

class UsbHost {
 public:
  enum class Status { kOk, kStall, kTimeout };
  using Bytes = std::vector<std::uint8_t>;
  struct Result {
    Status status = Status::kOk;
    Bytes data;
  };

  UsbHost(ChipideaModel& wire, std::function<void()> interrupt) : wire_(wire), interrupt_(std::move(interrupt)) {}

  void Service() {
    for (int i = 0; i < 8 && wire_.InterruptPending(); ++i) interrupt_();
  }

  void Reset(bool high_speed) {
    wire_.BeginReset();
    Service();
    wire_.EndReset(high_speed);
    Service();
    address = 0;
    packet_size = high_speed ? 512 : 64;
    ResetToggles();
  }

  // Without a data stage, or with one to the host.
  Result Control(const UsbRequest& request) {
    Result result = Begin(request) ? Result{} : Result{Status::kTimeout, {}};
    if (result.status != Status::kOk) return result;
    const bool in = (request.type & 0x80) != 0;
    int toggle = 1;
    while (in && request.length != 0) {
      ChipideaModel::Packet packet = NextIn(0);
      if (packet.answer != ChipideaModel::Answer::kAck) return {StatusOf(packet.answer), {}};
      if (packet.toggle != toggle) return {Status::kTimeout, {}};
      toggle = 1 - toggle;
      result.data.insert(result.data.end(), packet.data.begin(), packet.data.end());
      if (packet.data.size() < 64 || result.data.size() >= request.length) break;
    }
    result.status = in && request.length != 0 ? StatusOf(NextOut(0, 1, {})) : StatusOf(NextIn(0).answer);
    return result;
  }

  // Only the SETUP packet, three attempts.
  bool Begin(const UsbRequest& request) {
    const std::array<std::uint8_t, 8> bytes = {request.type,        request.request,     Low(request.value),
                                               High(request.value), Low(request.index),  High(request.index),
                                               Low(request.length), High(request.length)};
    for (int i = 0; i < 3; ++i) {
      const auto answer = wire_.Setup(address, bytes);
      Service();
      if (answer == ChipideaModel::Answer::kAck) return true;
    }
    return false;
  }

  Result GetDescriptor(int type, int index = 0, std::uint16_t length = 4096) {
    return Control({0x80, 6, static_cast<std::uint16_t>(type << 8 | index), 0, length});
  }

  bool SetAddress(std::uint16_t new_address) {
    if (Control({0x00, 5, new_address, 0, 0}).status != Status::kOk) return false;
    address = new_address;
    return true;
  }

  Status Configure(std::uint16_t value = 1) {
    const Status status = Control({0x00, 9, value, 0, 0}).status;
    ResetToggles();
    return status;
  }

  // Reset, address, configuration: the minimum of a host.
  bool Enumerate(bool high_speed = true) {
    Reset(high_speed);
    return SetAddress(7) && Configure() == Status::kOk;
  }

  // One transfer; `end`: an empty packet follows when its last one was full.
  Status BulkOut(const Bytes& data, bool end = false) {
    std::size_t at = 0;
    do {
      const std::size_t size = data.size() - at < packet_size ? data.size() - at : packet_size;
      const auto answer = NextOut(
          1, out_toggle,
          Bytes(data.begin() + static_cast<std::ptrdiff_t>(at), data.begin() + static_cast<std::ptrdiff_t>(at + size)));
      if (answer != ChipideaModel::Answer::kAck) return StatusOf(answer);
      out_toggle = 1 - out_toggle;
      at += size;
    } while (at < data.size());
    if (!end || data.size() % packet_size != 0 || data.empty()) return Status::kOk;
    return BulkOut({}, false);
  }

  // One transfer of at most `size` bytes: it ends with a packet that is not full.
  Result BulkIn(std::size_t size = 1024) {
    Result result;
    while (result.data.size() < size) {
      ChipideaModel::Packet packet = NextIn(1);
      if (packet.answer != ChipideaModel::Answer::kAck) {
        result.status = StatusOf(packet.answer);
        return result;
      }
      if (packet.toggle != in_toggle) continue;  // a repetition
      in_toggle = 1 - in_toggle;
      result.data.insert(result.data.end(), packet.data.begin(), packet.data.end());
      if (packet.data.size() < packet_size) break;
    }
    return result;
  }

  void ResetToggles() { in_toggle = out_toggle = 0; }

  int address = 0;
  std::size_t packet_size = 512;
  int in_toggle = 0, out_toggle = 0;

 private:
  static std::uint8_t Low(std::uint16_t value) { return static_cast<std::uint8_t>(value & 0xFF); }
  static std::uint8_t High(std::uint16_t value) { return static_cast<std::uint8_t>(value >> 8); }

  static Status StatusOf(ChipideaModel::Answer answer) {
    if (answer == ChipideaModel::Answer::kAck) return Status::kOk;
    return answer == ChipideaModel::Answer::kStall ? Status::kStall : Status::kTimeout;
  }

  ChipideaModel::Packet NextIn(int endpoint) {
    ChipideaModel::Packet packet;
    for (int i = 0; i < kPatience; ++i) {
      packet = wire_.In(address, endpoint);
      Service();
      if (packet.answer == ChipideaModel::Answer::kAck || packet.answer == ChipideaModel::Answer::kStall) break;
    }
    return packet;
  }

  ChipideaModel::Answer NextOut(int endpoint, int toggle, const Bytes& data) {
    auto answer = ChipideaModel::Answer::kNothing;
    for (int i = 0; i < kPatience; ++i) {
      answer = wire_.Out(address, endpoint, toggle, data);
      Service();
      if (answer == ChipideaModel::Answer::kAck || answer == ChipideaModel::Answer::kStall) break;
    }
    return answer;
  }

  static constexpr int kPatience = 4;

  ChipideaModel& wire_;
  std::function<void()> interrupt_;
};

}  // namespace omni::support
