// A simulated USB bus: bases that respond as firmware does, or wrongly, and links without a USB stack.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/wire/messages.h"
#include "service/base/clock.h"
#include "service/device/usb/usb_bus.h"

namespace omni::test {

using UsbFrame = std::vector<std::uint8_t>;

inline wire::Hello GoodUsbHello(const std::string& serial) {
  wire::Hello hello;
  hello.firmware_version = 0x0102;
  hello.capabilities = wire::kCurrentSensors | wire::kArming;
  std::memcpy(hello.serial, serial.data(), std::min(serial.size(), sizeof hello.serial));
  hello.field_lsb_T = 5.8e-8F;
  hello.field_full_scale = 27376;
  hello.current_max_A = 15;
  return hello;
}

// How a base handles frames: one telemetry per millisecond of its own clock, arming in two steps.
struct FakeBase {
  wire::Hello hello = GoodUsbHello("A17");
  wire::State state = wire::State::kIdle;
  std::uint32_t faults = wire::kFaultNotArmed;
  std::uint32_t refuses_arm = 0;  // faults that it reports
  bool follows = false;           // coils have the commanded currents at once, and a missing host is a fault
  int self_test_ticks = 0;        // duration of the self-test that the first ARM starts; 0: none
  bool answers_hello = true;
  bool keeps_fault = false;
  std::uint64_t t_us = 5'000'000;
  std::uint16_t seq = 65530;  // about to wrap
  std::uint32_t nonce = 77;
  wire::Telemetry telemetry;

  std::vector<wire::Command> commands;
  std::vector<wire::Arm> arms;
  std::vector<std::uint16_t> seqs;  // of all received frames
  int stops = 0;
  int bad = 0;

  FakeBase() {
    for (std::int16_t& temperature : telemetry.temperature) temperature = 2400;
  }

  template <class Message>
  UsbFrame Frame(const Message& message) {
    UsbFrame frame(wire::kFrameSizeMax);
    frame.resize(wire::Encode(message, seq++, t_us, frame.data(), frame.size()).size);
    EXPECT_FALSE(frame.empty());
    return frame;
  }

  UsbFrame Tick() {
    t_us += 1000;
    if (state == wire::State::kSelfTest && self_test_ticks > 0 && --self_test_ticks == 0) state = wire::State::kIdle;
    telemetry.state = state;
    telemetry.faults = faults;
    telemetry.fresh_mask = 0xFF;
    telemetry.supply = 14400;
    return Frame(telemetry);
  }

  // The answers to one frame.
  std::vector<UsbFrame> Take(const UsbFrame& frame) {
    wire::FrameView view;
    if (wire::OpenFrame(frame.data(), frame.size(), view) != wire::Status::kOk) {
      ++bad;
      return {};
    }
    seqs.push_back(view.header.seq);
    if (view.header.type == wire::MessageType::kHello && answers_hello) return {Frame(hello)};
    if (view.header.type == wire::MessageType::kFault && keeps_fault) return {Frame(KeptFault())};
    wire::Arm arm;
    if (wire::Decode(view, arm) == wire::Status::kOk) return {Frame(TakeArm(arm))};
    wire::Command command;
    if (wire::DecodeCommand(view, hello.current_max_A, command) == wire::Status::kOk) TakeCommand(command, view);
    return {};
  }

  static wire::FaultEvent KeptFault() {
    wire::FaultEvent event;
    event.fault = event.faults = wire::kFaultOverTemperature;
    event.state = wire::State::kArmed;
    event.part = 2;
    event.after_reset = 1;
    event.value = 71.5F;
    event.t_us = 12'345'678;
    return event;
  }

  wire::Arm TakeArm(const wire::Arm& arm) {
    arms.push_back(arm);
    wire::Arm answer;
    answer.nonce = nonce;
    if (refuses_arm != 0) {
      answer.step = wire::ArmStep::kRefused;
      answer.faults = refuses_arm;
    } else if (self_test_ticks > 0) {
      answer.step = wire::ArmStep::kRefused;
      answer.faults = wire::kFaultSelfTest;
      state = wire::State::kSelfTest;
    } else if (arm.step == wire::ArmStep::kRequest) {
      answer.step = wire::ArmStep::kChallenge;
    } else if (arm.step == wire::ArmStep::kConfirm && arm.nonce == nonce) {
      answer.step = wire::ArmStep::kArmed;
      state = wire::State::kArmed;
      faults = 0;
    } else {
      answer.step = wire::ArmStep::kRefused;
    }
    return answer;
  }

  void TakeCommand(const wire::Command& command, const wire::FrameView& view) {
    commands.push_back(command);
    telemetry.ack_seq = view.header.seq;
    telemetry.ack_host_us = command.host_us;
    telemetry.ack_rx_device_us = static_cast<std::uint32_t>(t_us);
    if (!follows) return;
    faults &= ~wire::kFaultHostSilent;
    for (int k = 0; k < wire::kCoils; ++k) {
      for (auto& step : telemetry.current) {
        step[k] = wire::ToCounts<std::int16_t>(static_cast<double>(command.set_point_A[k]), wire::kCurrentUnit_A);
      }
    }
  }
};

// The pipe to one FakeBase. Without a thread the test pumps it; with one it runs by itself, faster than real time.
class FakeUsbLink final : public device::UsbLink {
 public:
  explicit FakeUsbLink(FakeBase& base, bool threaded = false) : base_(base), threaded_(threaded) {}
  ~FakeUsbLink() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  base::Status Start(device::UsbHandler& handler) override {
    handler_ = &handler;
    Pump();  // a requested HELLO has arrived when Start returns
    if (threaded_) {
      thread_ = std::thread([this] {
        while (!stop_) {
          Step();
          std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
      });
    }
    return base::Ok{};
  }
  void Wake() noexcept override {
    ++wakes;
    woken_ns_ = base::MonotonicNow_ns();
  }

  void Give(const UsbFrame& frame) { handler_->OnFrame(frame.data(), frame.size(), base::MonotonicNow_ns()); }

  // Transfers pending frames, and the base's responses to them, until there are none.
  void Pump() {
    for (int i = 0; i < 20; ++i) {
      UsbFrame frame(wire::kFrameSizeMax);
      // As if the link had responded at once: a test that does not get the processor for a while is not a blocked bus.
      const std::int64_t t_ns = woken_ns_ != 0 ? woken_ns_.load() : base::MonotonicNow_ns();
      frame.resize(handler_->NextFrame(t_ns, frame.data(), frame.size()));
      if (frame.empty()) return;
      for (const UsbFrame& answer : base_.Take(frame)) Give(answer);
    }
    ADD_FAILURE() << "the session never stops sending";
  }
  // One millisecond of the base.
  void Step() {
    Give(base_.Tick());
    Pump();
  }

  void Unplug() { handler_->OnGone(); }

  std::atomic<int> wakes{0};

 private:
  FakeBase& base_;
  bool threaded_;
  device::UsbHandler* handler_ = nullptr;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> woken_ns_{0};
  std::thread thread_;
};

class FakeUsbBus final : public device::UsbBus {
 public:
  struct Entry {
    device::UsbBase listed;
    FakeBase base;
    std::string open_error;     // empty: it can be opened
    std::string control_error;  // likewise
  };
  explicit FakeUsbBus(bool threaded = false) : threaded_(threaded) {}

  Entry& Add(const std::string& serial, const std::string& port = "1-1") {
    entries.push_back(std::make_unique<Entry>());
    Entry& entry = *entries.back();
    entry.listed = {.serial = serial,
                    .node = "/dev/bus/usb/001/00" + std::to_string(entries.size()),
                    .speed = "480 Mbit/s",
                    .port = port,
                    .problem = ""};
    entry.base.hello = GoodUsbHello(serial);
    return entry;
  }

  base::Result<std::vector<device::UsbBase>> ListBases() override {
    std::vector<device::UsbBase> bases;
    for (const auto& entry : entries) bases.push_back(entry->listed);
    return bases;
  }
  base::Result<std::unique_ptr<device::UsbLink>> Open(const device::UsbBase& base) override {
    Entry* entry = Find(base);
    if (entry == nullptr) return base::Error{base.node + " is gone"};
    if (!entry->open_error.empty()) return base::Error{entry->open_error};
    auto made = std::make_unique<FakeUsbLink>(entry->base, threaded_);
    link = made.get();
    return std::unique_ptr<device::UsbLink>(std::move(made));
  }
  base::Status ControlOut(const device::UsbBase& base, wire::UsbRequest request, std::uint16_t /*value*/) override {
    Entry* entry = Find(base);
    if (entry == nullptr || !entry->control_error.empty()) return base::Error{entry ? entry->control_error : "gone"};
    EXPECT_EQ(request, wire::UsbRequest::kEstop);
    ++entry->base.stops;
    return base::Ok{};
  }
  base::Result<std::vector<std::uint8_t>> ControlIn(const device::UsbBase& base, wire::UsbRequest request) override {
    Entry* entry = Find(base);
    if (entry == nullptr || !entry->control_error.empty()) return base::Error{entry ? entry->control_error : "gone"};
    EXPECT_EQ(request, wire::UsbRequest::kHello);
    return entry->base.Frame(entry->base.hello);
  }

  std::vector<std::unique_ptr<Entry>> entries;
  FakeUsbLink* link = nullptr;  // of the newest Open

 private:
  Entry* Find(const device::UsbBase& base) {
    for (const auto& entry : entries) {
      if (entry->listed.node == base.node) return entry.get();
    }
    return nullptr;
  }

  bool threaded_;
};

}  // namespace omni::test
