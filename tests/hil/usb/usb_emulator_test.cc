// The emulated bus seen by the real libusb: enumeration, endpoint 0, bulk transfers both ways, cancellation, and a
// cable that is pulled while transfers are in flight.
#include <gtest/gtest.h>
#include <libusb.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "firmware/drivers/usb_descriptors.h"
#include "firmware/wire/frame.h"
#include "firmware/wire/usb_ids.h"
#include "tests/hil/usb/usb_emulator.h"

namespace omni::hil {
namespace {

namespace usb = drivers::usb;
using std::chrono::milliseconds;

constexpr unsigned kTimeout_ms = 2000;

// Gives back what it gets, and knows one vendor request.
class Echo final : public UsbFunction {
 public:
  void HostFrame(const std::uint8_t* data, std::size_t size) override {
    const std::lock_guard lock(mutex_);
    frames_.emplace_back(data, data + size);
    ++received_;
  }
  std::size_t NextFrame(std::uint8_t* frame, std::size_t capacity) override {
    const std::lock_guard lock(mutex_);
    if (frames_.empty() || frames_.front().size() > capacity) return 0;
    const std::size_t size = frames_.front().size();
    std::memcpy(frame, frames_.front().data(), size);
    frames_.pop_front();
    return size;
  }
  int VendorRequest(std::uint8_t request, std::uint16_t value, std::uint16_t, std::uint8_t* answer,
                    std::size_t) override {
    if (request != usb::kRequestHello) return -1;
    answer[0] = static_cast<std::uint8_t>(value);
    return 1;
  }
  void Unplugged() override {
    const std::lock_guard lock(mutex_);
    frames_.clear();
  }
  int received() const { return received_; }

 private:
  std::mutex mutex_;
  std::deque<Frame> frames_;
  std::atomic<int> received_{0};
};

// One bus for all tests: umockdev has one test bed in a process.
Echo& TheEcho() {
  static Echo echo;
  return echo;
}
UsbEmulator& TheBus() {
  static const std::unique_ptr<UsbEmulator> kBus = [] {
    auto created = UsbEmulator::Create(TheEcho(), "echo-1");
    if (!created) {
      std::fprintf(stderr, "%s\n", created.error().c_str());
      std::abort();
    }
    return std::move(*created);
  }();
  return *kBus;
}

class UsbEmulatorTest : public testing::Test {
 protected:
  void SetUp() override {
    const base::Status plugged = TheBus().Plug();
    ASSERT_TRUE(plugged.ok()) << plugged.error();
    ASSERT_EQ(libusb_init(&context_), 0);
  }
  void TearDown() override {
    Close();
    if (context_ != nullptr) libusb_exit(context_);
    TheBus().SetFaults({}, {});
    TheBus().Unplug();
  }

  void Open() {
    handle_ = libusb_open_device_with_vid_pid(context_, wire::kUsbVendorId, wire::kUsbProductId);
    ASSERT_NE(handle_, nullptr);
    ASSERT_EQ(libusb_claim_interface(handle_, 0), 0);
  }
  void Close() {
    if (handle_ != nullptr) libusb_close(handle_);
    handle_ = nullptr;
  }
  int Write(std::vector<std::uint8_t> bytes) {
    int sent = 0;
    const int result = libusb_bulk_transfer(handle_, usb::kEndpointOut, bytes.data(), static_cast<int>(bytes.size()),
                                            &sent, kTimeout_ms);
    return result != 0 ? result : sent;
  }
  std::vector<std::uint8_t> Read(unsigned timeout_ms = kTimeout_ms) {
    std::vector<std::uint8_t> bytes(512);
    int size = 0;
    TheBus().Pump();
    read_result_ = libusb_bulk_transfer(handle_, usb::kEndpointIn, bytes.data(), 512, &size, timeout_ms);
    bytes.resize(static_cast<std::size_t>(size));
    return bytes;
  }

  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
  int read_result_ = 0;
};

TEST_F(UsbEmulatorTest, EnumeratesWithTheFirmwaresDescriptors) {
  Open();
  libusb_device* const device = libusb_get_device(handle_);
  libusb_device_descriptor descriptor;
  ASSERT_EQ(libusb_get_device_descriptor(device, &descriptor), 0);
  EXPECT_EQ(descriptor.bcdUSB, 0x0210);
  EXPECT_EQ(libusb_get_device_speed(device), LIBUSB_SPEED_HIGH);
  EXPECT_EQ(libusb_get_max_packet_size(device, usb::kEndpointIn), 512);
  unsigned char text[64] = {};
  EXPECT_GT(libusb_get_string_descriptor_ascii(handle_, descriptor.iSerialNumber, text, sizeof text), 0);
  EXPECT_STREQ(reinterpret_cast<const char*>(text), "echo-1");
  EXPECT_GT(libusb_get_string_descriptor_ascii(handle_, descriptor.iManufacturer, text, sizeof text), 0);
  EXPECT_STREQ(reinterpret_cast<const char*>(text), "Omni");
  libusb_bos_descriptor* bos = nullptr;
  ASSERT_EQ(libusb_get_bos_descriptor(handle_, &bos), 0);
  EXPECT_EQ(bos->bNumDeviceCaps, 2);
  libusb_free_bos_descriptor(bos);
}

TEST_F(UsbEmulatorTest, AnswersVendorRequestsAndStallsOthers) {
  Open();
  std::uint8_t answer[64] = {};
  EXPECT_EQ(libusb_control_transfer(handle_, wire::kUsbRequestTypeIn, usb::kRequestHello, 77, 0, answer, sizeof answer,
                                    kTimeout_ms),
            1);
  EXPECT_EQ(answer[0], 77);
  std::uint8_t ms_os[512];
  EXPECT_EQ(libusb_control_transfer(handle_, wire::kUsbRequestTypeIn, usb::kRequestMsOs, 0, usb::kMsOsDescriptorIndex,
                                    ms_os, sizeof ms_os, kTimeout_ms),
            static_cast<int>(usb::kMsOs.size()));
  EXPECT_EQ(libusb_control_transfer(handle_, wire::kUsbRequestTypeIn, 99, 0, 0, answer, sizeof answer, kTimeout_ms),
            LIBUSB_ERROR_PIPE);
}

TEST_F(UsbEmulatorTest, CarriesFramesBothWaysAndTimesOutWithoutOne) {
  Open();
  for (int size : {1, 64, 511, 512}) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + size);
    ASSERT_EQ(Write(bytes), size);
    if (size <= static_cast<int>(wire::kFrameSizeMax)) {
      EXPECT_EQ(Read(), bytes) << size;
    }
  }
  const auto started = std::chrono::steady_clock::now();
  EXPECT_TRUE(Read(50).empty());
  EXPECT_EQ(read_result_, LIBUSB_ERROR_TIMEOUT);
  EXPECT_GE(std::chrono::steady_clock::now() - started, milliseconds(45));
}

struct Flight {
  std::mutex mutex;
  std::condition_variable done;
  int pending = 0;
  std::vector<libusb_transfer_status> statuses;
  static void OnDone(libusb_transfer* transfer) {
    auto& flight = *static_cast<Flight*>(transfer->user_data);
    const std::lock_guard lock(flight.mutex);
    flight.statuses.push_back(transfer->status);
    --flight.pending;
    flight.done.notify_all();
  }
};

class InFlight : public UsbEmulatorTest {
 protected:
  static constexpr int kTransfers = 8;
  void Submit() {
    Open();
    events_ = std::thread([this] {
      while (!stop_) {
        timeval patience{0, 20'000};
        libusb_handle_events_timeout_completed(context_, &patience, nullptr);
      }
    });
    for (int i = 0; i < kTransfers; ++i) {
      transfers_.push_back(libusb_alloc_transfer(0));
      libusb_fill_bulk_transfer(transfers_.back(), handle_, usb::kEndpointIn, buffers_[i], 512, Flight::OnDone,
                                &flight_, 0);
      ++flight_.pending;
      ASSERT_EQ(libusb_submit_transfer(transfers_.back()), 0);
    }
  }
  bool AllDone(int left = 0) {
    std::unique_lock lock(flight_.mutex);
    return flight_.done.wait_for(lock, milliseconds(2000), [&] { return flight_.pending == left; });
  }
  void TearDown() override {
    stop_ = true;
    if (events_.joinable()) events_.join();
    for (libusb_transfer* transfer : transfers_) libusb_free_transfer(transfer);
    UsbEmulatorTest::TearDown();
  }

  Flight flight_;
  std::vector<libusb_transfer*> transfers_;
  std::uint8_t buffers_[kTransfers][512] = {};
  std::atomic<bool> stop_{false};
  std::thread events_;
};

TEST_F(InFlight, TransfersCompleteInOrder) {
  Submit();
  for (std::uint8_t i = 0; i < 3; ++i) {
    TheEcho().HostFrame(&i, 1);
    TheBus().Pump();
  }
  ASSERT_TRUE(AllDone(kTransfers - 3));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(buffers_[i][0], i);
  for (libusb_transfer* transfer : transfers_) libusb_cancel_transfer(transfer);
  ASSERT_TRUE(AllDone());
  EXPECT_EQ(flight_.statuses.back(), LIBUSB_TRANSFER_CANCELLED);
}

TEST_F(InFlight, TransfersFailOnUnplugAndReplugWorks) {
  Submit();
  const std::uint64_t aborted = TheBus().counts().aborted;
  TheBus().Unplug();
  ASSERT_TRUE(AllDone());
  for (const libusb_transfer_status status : flight_.statuses) EXPECT_EQ(status, LIBUSB_TRANSFER_NO_DEVICE);
  EXPECT_EQ(TheBus().counts().aborted - aborted, static_cast<std::uint64_t>(kTransfers));
  EXPECT_EQ(Write({1, 2, 3}), LIBUSB_ERROR_NO_DEVICE);
  Close();
  ASSERT_TRUE(TheBus().Plug().ok());
  for (int i = 0; i < 100 && handle_ == nullptr; ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    handle_ = libusb_open_device_with_vid_pid(context_, wire::kUsbVendorId, wire::kUsbProductId);
  }
  ASSERT_NE(handle_, nullptr) << "hotplug: the device is back";
  ASSERT_EQ(libusb_claim_interface(handle_, 0), 0);
  EXPECT_EQ(Write({1, 2, 3}), 3);
  EXPECT_EQ(Read(), (std::vector<std::uint8_t>{1, 2, 3}));
}

TEST_F(UsbEmulatorTest, ReportsHotplugEvents) {
  struct Seen {
    int arrived = 0, left = 0;
  } seen;
  const auto on_event = [](libusb_context*, libusb_device*, libusb_hotplug_event event, void* data) {
    auto& counts = *static_cast<Seen*>(data);
    ++(event == LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED ? counts.arrived : counts.left);
    return 0;
  };
  libusb_hotplug_callback_handle callback;
  ASSERT_EQ(libusb_hotplug_register_callback(
                context_, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0, wire::kUsbVendorId,
                wire::kUsbProductId, LIBUSB_HOTPLUG_MATCH_ANY, on_event, &seen, &callback),
            0);
  const auto wait = [&](auto until) {
    for (int i = 0; i < 100 && !until(); ++i) {
      timeval patience{0, 20'000};
      libusb_handle_events_timeout_completed(context_, &patience, nullptr);
    }
    return until();
  };
  TheBus().Unplug();
  EXPECT_TRUE(wait([&] { return seen.left == 1; }));
  ASSERT_TRUE(TheBus().Plug().ok());
  EXPECT_TRUE(wait([&] { return seen.arrived == 1; }));
}

TEST_F(UsbEmulatorTest, DamagesFramesAsConfigured) {
  Open();
  TheBus().SetFaults({}, {.corrupt = 1});
  ASSERT_EQ(Write({0, 0, 0, 0}), 4);
  const std::vector<std::uint8_t> damaged = Read();
  ASSERT_EQ(damaged.size(), 4U);
  int bits = 0;
  for (const std::uint8_t byte : damaged) bits += __builtin_popcount(byte);
  EXPECT_EQ(bits, 1);
  TheBus().SetFaults({.drop = 1}, {});
  ASSERT_EQ(Write({5}), 1);
  EXPECT_TRUE(Read(30).empty());
}

// A second program looks while the first one holds the base: each gets its own transfers back.
TEST_F(UsbEmulatorTest, ServesTwoClients) {
  Open();
  libusb_context* other = nullptr;
  ASSERT_EQ(libusb_init(&other), 0);
  libusb_device_handle* second = libusb_open_device_with_vid_pid(other, wire::kUsbVendorId, wire::kUsbProductId);
  ASSERT_NE(second, nullptr);
  std::thread reader([&] { EXPECT_EQ(Read(), (std::vector<std::uint8_t>{9})); });
  for (int i = 0; i < 20; ++i) {
    std::uint8_t answer = 0;
    EXPECT_EQ(libusb_control_transfer(second, wire::kUsbRequestTypeIn, usb::kRequestHello,
                                      static_cast<std::uint16_t>(i), 0, &answer, 1, kTimeout_ms),
              1);
    EXPECT_EQ(answer, i);
  }
  const std::uint8_t nine = 9;
  TheEcho().HostFrame(&nine, 1);
  TheBus().Pump();
  reader.join();
  libusb_close(second);
  libusb_exit(other);
}

}  // namespace
}  // namespace omni::hil

int main(int argc, char** argv) {
  const omni::base::Status mocked = omni::hil::EnterMockEnvironment(argv);
  if (!mocked) {
    std::fprintf(stderr, "%s\n", mocked.error().c_str());
    return 1;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
