#include "tests/hil/chain.h"

#include <algorithm>
#include <cstring>

#include "firmware/wire/usb_ids.h"

namespace omni::hil {
namespace {

// An empty HELLO requests one.
Frame RequestHello() {
  Frame frame(wire::kHeaderSize + wire::kTrailerSize);
  wire::SealFrame({.type = wire::MessageType::kHello}, 0, frame.data(), frame.size());
  return frame;
}

Frame EstopFrame(std::uint8_t reason) {
  Frame frame(wire::FrameSize<wire::Estop>());
  wire::Estop estop;
  estop.reason = reason;
  wire::Encode(estop, 0, 0, frame.data(), frame.size());
  return frame;
}

}  // namespace

// For the vendor request: the firmware has its own HELLO; here it is requested from the core.
Chain::Chain(sim::Plant& plant, HilBoard& board) : plant_(plant), board_(board) {
  telemetry_.state = wire::State::kBoot;
  Push(RequestHello());
}

base::Status Chain::Step() {
  HandleHostFrames();
  request_.op = firmware::LockstepOp::kStep;
  request_.inputs = plant_.inputs();
  firmware::LockstepAnswer answer;
  const base::Status stepped = board_.Step(request_, answer);
  if (!stepped) return stepped;
  outputs_ = answer.outputs;
  GiveHostFrames(answer);
  plant_.Step(outputs_);
  ++counts_.steps;
  return base::Ok{};
}

base::Status Chain::Reset(firmware::ResetCause cause) {
  plant_.ResetClock();
  telemetry_ = {};
  telemetry_.state = wire::State::kBoot;
  {
    const std::lock_guard lock(mutex_);
    from_host_.clear();
    to_host_.clear();
  }
  Push(RequestHello());
  return board_.Reset(cause);
}

void Chain::Push(const Frame& frame) {
  const std::lock_guard lock(mutex_);
  if (from_host_.size() == kFromHostMax) {
    ++counts_.lost_to_core;
    return;
  }
  from_host_.push_back(frame);
}

void Chain::HandleHostFrames() {
  {
    const std::lock_guard lock(mutex_);
    for (firmware::LockstepFrame& frame : request_.frames) {
      frame.size = 0;
      if (from_host_.empty()) continue;
      const Frame& oldest = from_host_.front();
      frame.size = static_cast<std::uint16_t>(std::min(oldest.size(), sizeof frame.bytes));
      std::memcpy(frame.bytes, oldest.data(), frame.size);
      from_host_.pop_front();
    }
  }
  for (const firmware::LockstepFrame& frame : request_.frames) CheckCommand(frame);
}

void Chain::CheckCommand(const firmware::LockstepFrame& frame) {
  wire::FrameView view;
  wire::Command command;
  if (frame.size == 0 || wire::OpenFrame(frame.bytes, frame.size, view) != wire::Status::kOk ||
      wire::Decode(view, command) != wire::Status::kOk) {
    return;
  }
  ++counts_.commands;
  command_ns_ = plant_.now_ns();
  for (std::size_t k = 0; k < set_point_A_.size(); ++k) {
    set_point_A_[k] = command.mode == wire::Mode::kCurrent ? static_cast<double>(command.set_point_A[k]) : 0;
  }
}

void Chain::GiveHostFrames(const firmware::LockstepAnswer& answer) {
  for (const firmware::LockstepFrame& frame : answer.frames) {
    if (frame.size == 0 || frame.size > sizeof frame.bytes) continue;
    CheckAnswer(frame);
    const std::lock_guard lock(mutex_);
    if (to_host_.size() == kToHostMax) {
      to_host_.pop_front();
      ++counts_.lost_to_host;
    }
    to_host_.emplace_back(frame.bytes, frame.bytes + frame.size);
  }
}

void Chain::CheckAnswer(const firmware::LockstepFrame& frame) {
  wire::FrameView view;
  if (wire::OpenFrame(frame.bytes, frame.size, view) != wire::Status::kOk) return;
  if (view.header.type == wire::MessageType::kTelemetry) {
    if (wire::Decode(view, telemetry_) == wire::Status::kOk) ++counts_.telemetry;
  } else if (view.header.type == wire::MessageType::kHello) {
    const std::lock_guard lock(mutex_);
    hello_.assign(frame.bytes, frame.bytes + frame.size);
  }
}

sim::HostView Chain::host_view() const {
  return {.set_point_A = set_point_A_,
          .command_age_s = static_cast<double>(plant_.now_ns() - command_ns_) * 1e-9,
          .faults = telemetry_.faults};
}

void Chain::HostFrame(const std::uint8_t* data, std::size_t size) { Push(Frame(data, data + size)); }

std::size_t Chain::NextFrame(std::uint8_t* frame, std::size_t capacity) {
  const std::lock_guard lock(mutex_);
  if (to_host_.empty()) return 0;
  const std::size_t size = std::min(to_host_.front().size(), capacity);
  std::memcpy(frame, to_host_.front().data(), size);
  to_host_.pop_front();
  return size;
}

int Chain::VendorRequest(std::uint8_t request, std::uint16_t value, std::uint16_t /*index*/, std::uint8_t* answer,
                         std::size_t capacity) {
  if (request == static_cast<std::uint8_t>(wire::UsbRequest::kEstop)) {
    Push(EstopFrame(static_cast<std::uint8_t>(value)));
    return 0;
  }
  if (request != static_cast<std::uint8_t>(wire::UsbRequest::kHello)) return -1;
  const std::lock_guard lock(mutex_);
  if (hello_.empty() || hello_.size() > capacity) return -1;
  std::memcpy(answer, hello_.data(), hello_.size());
  return static_cast<int>(hello_.size());
}

void Chain::Unplugged() {
  const std::lock_guard lock(mutex_);
  from_host_.clear();
  to_host_.clear();
}

}  // namespace omni::hil
