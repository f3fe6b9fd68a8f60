// A host that does anything at any time, to a device whose interrupt comes late. Whatever it did: memory is respected
// (ASan and the model watch), no frame is invented, damaged, doubled or out of order, every frame that was accepted is
// accounted for, and a host that behaves finds a device that works.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/chips/usb_bench.h"

namespace omni::drivers::usb {
namespace test_drivers_usb_random {

using support::UsbBench;
using Status = support::UsbHost::Status;
using Bytes = UsbBench::Bytes;

// Both ends count their frames; the number stands in the first four bytes.
Bytes NumberedFrame(std::uint32_t number, std::size_t size) {
  Bytes frame = UsbBench::Frame(size, static_cast<int>(number * 7));
  for (std::size_t i = 0; i < 4; ++i) frame[i] = static_cast<std::uint8_t>(number >> (8 * i));
  return frame;
}

std::uint32_t NumberOf(const Bytes& frame) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number |= static_cast<std::uint32_t>(frame[i]) << (8 * i);
  return number;
}

class RandomHost : public UsbBench {
 public:
  explicit RandomHost(unsigned seed) : UsbBench(seed), random_(seed) {
    controller.stir = true;
    EXPECT_TRUE(device.Start());
    EXPECT_TRUE(host.Enumerate());
  }

  void Step() {
    switch (Pick(20)) {
      case 0:
        return SomeSetup();
      case 1:
        return void(controller.In(SomeAddress(), Pick(3)));
      case 2:
        return void(controller.Out(SomeAddress(), 0, Pick(2), Bytes(Pick(65))));
      case 3:
        return void(host.Control(SomeRequest()));
      case 4:
        return Disturb();
      case 5:
        return void(controller.stir = !controller.stir);
      case 6:
        return device.HandleInterrupt();
      default:
        return Work();
    }
  }

  void Settle() {
    controller.while_copying = nullptr;
    controller.while_priming = nullptr;
    controller.Plug();
    host.Service();
    controller.Resume();
    host.Service();
    ASSERT_TRUE(host.Enumerate(Pick(2) == 0));
    while (!Receive().empty()) {
    }
    for (int i = 0; i < 6; ++i) {
      const Bytes frame = NumberedFrame(++from_host_, 52);
      ASSERT_EQ(host.BulkOut(frame), Status::kOk);
      ASSERT_EQ(Receive(), frame);
      ASSERT_TRUE(Accept(NumberedFrame(++from_device_, 160)));
      ASSERT_EQ(host.BulkIn().data, NumberedFrame(from_device_, 160));
    }
    taken_from_host_ = from_host_;
    taken_from_device_ = from_device_;
    CheckAccounts();
  }

 private:
  int Pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
  std::size_t FrameSize() { return 4 + static_cast<std::size_t>(Pick(509)); }
  int SomeAddress() { return Pick(8) == 0 ? Pick(128) : host.address; }

  support::UsbRequest SomeRequest() {
    constexpr std::uint8_t kTypes[] = {0x00, 0x01, 0x02, 0x80, 0x81, 0x82, 0x40, 0xC0};
    constexpr std::uint16_t kValues[] = {0, 1, 2, 0x0100, 0x0200, 0x0302, 0x0600, 0x0F00};
    constexpr std::uint16_t kIndices[] = {0, 1, 7, 0x81, 0x01, 0x80};
    support::UsbRequest request{kTypes[Pick(8)], static_cast<std::uint8_t>(Pick(14)), kValues[Pick(8)],
                                kIndices[Pick(6)], static_cast<std::uint16_t>(Pick(2) == 0 ? 0 : Pick(300))};
    if (Pick(4) == 0) request.request = static_cast<std::uint8_t>(Pick(256));
    if (Pick(8) == 0) request.value = static_cast<std::uint16_t>(random_());
    if ((request.type & 0x60) == 0 && request.request == 5 && (request.type & 0x80) == 0) request.request = 6;
    return request;
  }

  // A SETUP without what belongs to it, perhaps while the one before is being handled.
  void SomeSetup() {
    const auto deliver = [this] {
      const support::UsbRequest r = SomeRequest();
      controller.Setup(host.address,
                       {r.type, r.request, static_cast<std::uint8_t>(r.value), static_cast<std::uint8_t>(r.value >> 8),
                        static_cast<std::uint8_t>(r.index), static_cast<std::uint8_t>(r.index >> 8),
                        static_cast<std::uint8_t>(r.length), static_cast<std::uint8_t>(r.length >> 8)});
    };
    if (Pick(3) == 0) controller.while_copying = deliver;
    if (Pick(3) == 0) controller.while_priming = deliver;
    deliver();
    if (Pick(2) == 0) host.Service();
  }

  void Disturb() {
    switch (Pick(40)) {
      case 0:
        controller.BeginReset();
        break;
      case 1:
        controller.EndReset(Pick(2) == 0);
        break;
      case 2:
        controller.Suspend();
        break;
      case 3:
        controller.Resume();
        break;
      case 4:
        controller.Unplug();
        break;
      case 5:
        controller.Plug();
        break;
      case 6:
        controller.DamageNext(1, Pick(2) == 0);
        break;
      case 7:
        host.out_toggle = Pick(2);
        break;
      case 8:
        host.in_toggle = Pick(2);
        break;
      case 9:
        host.Enumerate(Pick(2) == 0);
        break;
      default:
        break;
    }
  }

  // Frames both ways, whole or not, and the device's own loop.
  void Work() {
    switch (Pick(5)) {
      case 0: {
        const auto size = FrameSize();
        return void(host.BulkOut(NumberedFrame(++from_host_, size), Pick(8) != 0));
      }
      case 1:
        return TakeFromDevice(host.BulkIn());
      case 2:
        return void(Accept(NumberedFrame(++from_device_, FrameSize())));
      case 3:
        return TakeFromHost(Receive());
      default:
        return host.Service();
    }
  }

  Bytes Receive() {
    Bytes frame = UsbBench::Receive();
    handed_out_ += !frame.empty();
    return frame;
  }

  bool Accept(const Bytes& frame) {
    const bool accepted = Send(frame);
    accepted_ += accepted;
    return accepted;
  }

  // At high speed a frame is a packet, so it comes whole or not at all; at full speed a host that stops half-way glues
  // two of its frames together, which is what the frames' own CRC is for.
  void TakeFromHost(const Bytes& frame) {
    if (frame.size() < 4 || host.packet_size != 512 || !device.high_speed()) return;
    const std::uint32_t number = NumberOf(frame);
    EXPECT_EQ(frame, NumberedFrame(number, frame.size()));
    EXPECT_GT(number, taken_from_host_) << "doubled or out of order";
    EXPECT_LE(number, from_host_) << "invented";
    taken_from_host_ = number;
  }

  void TakeFromDevice(const support::UsbHost::Result& result) {
    if (result.status != Status::kOk || result.data.size() < 4 || host.packet_size != 512) return;
    const std::uint32_t number = NumberOf(result.data);
    EXPECT_EQ(result.data, NumberedFrame(number, result.data.size()));
    EXPECT_LE(number, from_device_) << "invented";
    EXPECT_GE(number, taken_from_device_) << "out of order";
    taken_from_device_ = number;
  }

  // Nothing waits any more: what was accepted has gone one of these ways.
  void CheckAccounts() {
    const UsbCounters& c = device.counters();
    EXPECT_EQ(accepted_ + c.received, c.sent + c.send_errors + c.send_overwritten + c.lost_in_reset + handed_out_);
    EXPECT_EQ(c.timeouts, 0U);
    EXPECT_TRUE(controller.complaints().empty()) << controller.complaints().front();
  }

  std::mt19937 random_;
  std::uint32_t from_host_ = 0, taken_from_host_ = 0;
  std::uint32_t from_device_ = 0, taken_from_device_ = 0;
  std::uint32_t accepted_ = 0, handed_out_ = 0;
};

TEST(UsbRandomHost, RandomOperationsAccountForEveryFrame) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    RandomHost host(seed);
    for (int round = 0; round < 25 && !testing::Test::HasFailure(); ++round) {
      for (int i = 0; i < 200; ++i) host.Step();
      host.Settle();
    }
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
}

}  // namespace test_drivers_usb_random
}  // namespace omni::drivers::usb
