#include "tests/hil/deep/redir_port.h"

#include <poll.h>
#include <sys/socket.h>
#include <usbredirparser.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include "firmware/drivers/usb_descriptors.h"
#include "firmware/wire/frame.h"
#include "firmware/wire/usb_ids.h"
#include "service/base/clock.h"

namespace omni::hil {
namespace {

namespace usb = drivers::usb;

constexpr const char* kVersion = "omni";
constexpr std::size_t kAnswerMax = 512;             // of endpoint 0: any descriptor, any frame
constexpr std::uint16_t kFirmwareVersion = 0x0100;  // for the port's log only; the host reads the descriptors
constexpr std::uint8_t kDirectionIn = 0x80;         // of bmRequestType
constexpr std::uint8_t kStandardToDevice = 0x00, kStandardToInterface = 0x01;
constexpr std::uint8_t kRequestSetConfiguration = 9, kRequestSetInterface = 11;
constexpr std::int64_t kPatience_ns = 200'000'000;

// Of the protocol's tables: OUT endpoints first, then IN.
constexpr std::size_t Slot(std::uint8_t endpoint) { return ((endpoint & 0x80U) >> 3) | (endpoint & 0x0FU); }

}  // namespace

// All are called from usbredirparser_do_read.
struct RedirPort::Callbacks {
  static RedirPort& Port(void* self) { return *static_cast<RedirPort*>(self); }

  static void Log(void*, int level, const char* text) {
    if (level <= usbredirparser_warning) std::fprintf(stderr, "usbredir: %s\n", text);
  }
  static int Read(void* self, std::uint8_t* data, int size) {
    const ssize_t got = recv(Port(self).socket_.get(), data, static_cast<std::size_t>(size), 0);
    if (got > 0) return static_cast<int>(got);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    Port(self).closed_ = true;
    return -1;
  }
  static int Write(void* self, std::uint8_t* data, int size) {
    const ssize_t sent = send(Port(self).socket_.get(), data, static_cast<std::size_t>(size), MSG_NOSIGNAL);
    if (sent >= 0) return static_cast<int>(sent);
    if (errno == EAGAIN || errno == EINTR) return 0;
    Port(self).closed_ = true;
    return -1;
  }
  static void Hello(void* self, usb_redir_hello_header*) { Port(self).greeted_ = true; }
  static void Reset(void* self) { Port(self).Reset(); }
  static void SetConfiguration(void* self, std::uint64_t id, usb_redir_set_configuration_header* header) {
    Port(self).SetConfiguration(id, header->configuration);
  }
  static void GetConfiguration(void* self, std::uint64_t id) {
    usb_redir_configuration_status_header status{usb_redir_success, Port(self).state_.configuration};
    usbredirparser_send_configuration_status(Port(self).parser_, id, &status);
  }
  static void SetInterface(void* self, std::uint64_t id, usb_redir_set_alt_setting_header* header) {
    Port(self).SetInterface(id, header->interface, header->alt);
  }
  static void GetInterface(void* self, std::uint64_t id, usb_redir_get_alt_setting_header* header) {
    usb_redir_alt_setting_status_header status{usb_redir_success, header->interface, 0};
    usbredirparser_send_alt_setting_status(Port(self).parser_, id, &status);
  }
  static void Control(void* self, std::uint64_t id, usb_redir_control_packet_header* header, std::uint8_t* data, int) {
    Port(self).Control(id, *header);
    usbredirparser_free_packet_data(Port(self).parser_, data);
  }
  static void Bulk(void* self, std::uint64_t id, usb_redir_bulk_packet_header* header, std::uint8_t* data, int size) {
    Port(self).Bulk(id, *header, data, size);
    usbredirparser_free_packet_data(Port(self).parser_, data);
  }
  static void Cancel(void* self, std::uint64_t id) { Port(self).Cancel(id); }

  // Required by the parser, although this base has no such endpoints and announces none.
  static void Ignore(void*) {}
  template <class Header>
  static void Refuse(void* self, std::uint64_t, Header*) {
    ++Port(self).counts_.refused;
  }
  template <class Header>
  static void RefuseData(void* self, std::uint64_t, Header*, std::uint8_t* data, int) {
    ++Port(self).counts_.refused;
    usbredirparser_free_packet_data(Port(self).parser_, data);
  }

  static void Set(usbredirparser& parser) {
    parser.log_func = Log;
    parser.read_func = Read;
    parser.write_func = Write;
    parser.hello_func = Hello;
    parser.reset_func = Reset;
    parser.set_configuration_func = SetConfiguration;
    parser.get_configuration_func = GetConfiguration;
    parser.set_alt_setting_func = SetInterface;
    parser.get_alt_setting_func = GetInterface;
    parser.control_packet_func = Control;
    parser.bulk_packet_func = Bulk;
    parser.cancel_data_packet_func = Cancel;
    parser.device_disconnect_ack_func = Ignore;
    parser.filter_reject_func = Ignore;
    parser.start_iso_stream_func = Refuse<usb_redir_start_iso_stream_header>;
    parser.stop_iso_stream_func = Refuse<usb_redir_stop_iso_stream_header>;
    parser.start_interrupt_receiving_func = Refuse<usb_redir_start_interrupt_receiving_header>;
    parser.stop_interrupt_receiving_func = Refuse<usb_redir_stop_interrupt_receiving_header>;
    parser.alloc_bulk_streams_func = Refuse<usb_redir_alloc_bulk_streams_header>;
    parser.free_bulk_streams_func = Refuse<usb_redir_free_bulk_streams_header>;
    parser.iso_packet_func = RefuseData<usb_redir_iso_packet_header>;
    parser.interrupt_packet_func = RefuseData<usb_redir_interrupt_packet_header>;
  }
};

RedirPort::RedirPort(base::UniqueFd socket, UsbFunction& function, const std::string& serial)
    : socket_(std::move(socket)), function_(function), parser_(usbredirparser_create()) {
  std::copy_n(serial.begin(), std::min(serial.size(), usb::kSerialMax), state_.serial);
  state_.high_speed = true;
  parser_->priv = this;
  Callbacks::Set(*parser_);
  std::uint32_t capabilities[USB_REDIR_CAPS_SIZE] = {};
  for (const int one :
       {usb_redir_cap_connect_device_version, usb_redir_cap_device_disconnect_ack,
        usb_redir_cap_ep_info_max_packet_size, usb_redir_cap_64bits_ids, usb_redir_cap_32bits_bulk_length}) {
    usbredirparser_caps_set_cap(capabilities, one);
  }
  usbredirparser_init(parser_, kVersion, capabilities, USB_REDIR_CAPS_SIZE, usbredirparser_fl_usb_host);
}

RedirPort::~RedirPort() { usbredirparser_destroy(parser_); }

void RedirPort::Plug() { wanted_ = true; }

void RedirPort::Unplug() {
  wanted_ = false;
  if (!plugged_) return;
  plugged_ = false;
  counts_.aborted += waiting_.size();
  waiting_.clear();
  function_.Unplugged();
  usbredirparser_send_device_disconnect(parser_);
}

bool RedirPort::HostIsBehind() const {
  return plugged_ && waiting_.empty() && base::MonotonicNow_ns() - fetched_ns_ < kPatience_ns;
}

void RedirPort::Serve() {
  pollfd ready{socket_.get(), POLLIN, 0};
  while (!closed_ && poll(&ready, 1, 0) > 0) usbredirparser_do_read(parser_);
  if (wanted_ && greeted_ && !plugged_) Appear();
  Pump();
  while (!closed_ && usbredirparser_has_data_to_write(parser_) > 0) {
    if (usbredirparser_do_write(parser_) != 0) break;
    pollfd room{socket_.get(), POLLOUT, 0};
    if (poll(&room, 1, 0) <= 0) break;
  }
}

void RedirPort::Appear() {
  plugged_ = true;
  ++counts_.plugged;
  Reset();
  ReportEndpoints();
  usb_redir_device_connect_header connect{};
  connect.speed = usb_redir_speed_high;
  connect.vendor_id = usb::kVendorId;
  connect.product_id = usb::kProductId;
  connect.device_version_bcd = kFirmwareVersion;
  usbredirparser_send_device_connect(parser_, &connect);
}

// Before the base appears and after each change of its configuration.
void RedirPort::ReportEndpoints() {
  usb_redir_ep_info_header endpoints{};
  std::fill(std::begin(endpoints.type), std::end(endpoints.type), std::uint8_t{usb_redir_type_invalid});
  for (const std::uint8_t control : {std::uint8_t{0x00}, std::uint8_t{0x80}}) {
    endpoints.type[Slot(control)] = usb_redir_type_control;
    endpoints.max_packet_size[Slot(control)] = usb::kControlPacket;
  }
  for (const std::uint8_t bulk : {usb::kEndpointOut, usb::kEndpointIn}) {
    endpoints.type[Slot(bulk)] = usb_redir_type_bulk;
    endpoints.max_packet_size[Slot(bulk)] = usb::kBulkPacketHigh;
  }
  usb_redir_interface_info_header interfaces{};
  interfaces.interface_count = 1;
  interfaces.interface_class[0] = wire::kUsbInterfaceClass;
  usbredirparser_send_interface_info(parser_, &interfaces);
  usbredirparser_send_ep_info(parser_, &endpoints);
}

// A reset of the bus [USB 2.0, 9.1.1.3].
void RedirPort::Reset() {
  state_.configuration = 0;
  state_.in_halted = state_.out_halted = false;
  waiting_.clear();
}

// The actions of the firmware's driver besides the answer; returns the bytes of the answer, < 0: stall.
int RedirPort::Ask(const usb::Setup& setup, std::uint8_t* data) {
  const usb::ControlAnswer answer = usb::AnswerControl(setup, state_, data);
  switch (answer.action) {
    case usb::ControlAction::kStall:
      return -1;
    case usb::ControlAction::kSetConfiguration:
      state_.configuration = answer.argument;
      state_.in_halted = state_.out_halted = false;
      return 0;
    case usb::ControlAction::kHalt:
    case usb::ControlAction::kUnhalt:
      (answer.argument == usb::kEndpointIn ? state_.in_halted : state_.out_halted) =
          answer.action == usb::ControlAction::kHalt;
      return 0;
    case usb::ControlAction::kRestart:
      state_.in_halted = state_.out_halted = false;
      return 0;
    case usb::ControlAction::kEstop:
    case usb::ControlAction::kHello:
      return function_.VendorRequest(setup.request, setup.value, setup.index, data, kAnswerMax);
    default:
      return static_cast<int>(answer.size);
  }
}

void RedirPort::Control(std::uint64_t id, usb_redir_control_packet_header header) {
  ++counts_.requests;
  std::uint8_t data[kAnswerMax];
  const int size = Ask({header.requesttype, header.request, header.value, header.index, header.length}, data);
  if (size < 0) ++counts_.stalls;
  header.status = size < 0 ? std::uint8_t{usb_redir_stall} : std::uint8_t{usb_redir_success};
  header.length = std::min(header.length, static_cast<std::uint16_t>(std::max(0, size)));
  const bool to_host = (header.requesttype & kDirectionIn) != 0 && header.length > 0;
  usbredirparser_send_control_packet(parser_, id, &header, to_host ? data : nullptr, to_host ? header.length : 0);
}

// The protocol has separate messages for two requests; the firmware handles them as ordinary requests.
void RedirPort::SetConfiguration(std::uint64_t id, std::uint8_t configuration) {
  ++counts_.requests;
  std::uint8_t data[kAnswerMax];
  const bool done = Ask({kStandardToDevice, kRequestSetConfiguration, configuration, 0, 0}, data) >= 0;
  if (!done) ++counts_.stalls;
  ReportEndpoints();
  usb_redir_configuration_status_header status{};
  status.status = done ? std::uint8_t{usb_redir_success} : std::uint8_t{usb_redir_stall};
  status.configuration = state_.configuration;
  usbredirparser_send_configuration_status(parser_, id, &status);
}

void RedirPort::SetInterface(std::uint64_t id, std::uint8_t interface, std::uint8_t alternate) {
  ++counts_.requests;
  std::uint8_t data[kAnswerMax];
  const bool done = Ask({kStandardToInterface, kRequestSetInterface, alternate, interface, 0}, data) >= 0;
  if (!done) ++counts_.stalls;
  ReportEndpoints();
  usb_redir_alt_setting_status_header status{};
  status.status = done ? std::uint8_t{usb_redir_success} : std::uint8_t{usb_redir_stall};
  status.interface = interface;
  usbredirparser_send_alt_setting_status(parser_, id, &status);
}

void RedirPort::Bulk(std::uint64_t id, usb_redir_bulk_packet_header header, const std::uint8_t* data, int size) {
  if (!plugged_) return;  // in transit when the cable was pulled
  const bool in = header.endpoint == usb::kEndpointIn;
  const bool there = (in || header.endpoint == usb::kEndpointOut) && state_.configuration != 0;
  const bool halted = in ? state_.in_halted : state_.out_halted;
  if (in && there && !halted) {
    fetched_ns_ = base::MonotonicNow_ns();
    waiting_.push_back({id, header.length | std::uint32_t{header.length_high} << 16, header.stream_id});
    return;
  }
  if (there && !halted) {
    ++counts_.frames_out;
    function_.HostFrame(data, static_cast<std::size_t>(size));
    header.status = usb_redir_success;
  } else {
    ++counts_.stalls;
    header.status = usb_redir_stall;
    header.length = 0;
  }
  usbredirparser_send_bulk_packet(parser_, id, &header, nullptr, 0);
}

void RedirPort::Cancel(std::uint64_t id) {
  const auto its =
      std::find_if(waiting_.begin(), waiting_.end(), [id](const Waiting& waiting) { return waiting.id == id; });
  if (its == waiting_.end()) return;  // its answer is in transit
  const Waiting cancelled = *its;
  waiting_.erase(its);
  ++counts_.cancelled;
  FinishIn(cancelled, usb_redir_cancelled, nullptr, 0);
}

void RedirPort::Pump() {
  std::uint8_t frame[wire::kFrameSizeMax];
  while (plugged_ && !waiting_.empty()) {
    const std::size_t size = function_.NextFrame(frame, sizeof frame);
    if (size == 0) return;
    const Waiting waiting = waiting_.front();
    waiting_.pop_front();
    ++counts_.frames_in;
    const bool fits = size <= waiting.length;  // otherwise a babble
    FinishIn(waiting, fits ? std::uint8_t{usb_redir_success} : std::uint8_t{usb_redir_babble}, frame, fits ? size : 0);
  }
}

void RedirPort::FinishIn(const Waiting& waiting, std::uint8_t status, const std::uint8_t* data, std::size_t size) {
  usb_redir_bulk_packet_header header{};
  header.endpoint = usb::kEndpointIn;
  header.status = status;
  header.length = static_cast<std::uint16_t>(size);
  header.stream_id = waiting.stream;
  // The parser copies; its parameter merely lacks a const.
  usbredirparser_send_bulk_packet(parser_, waiting.id, &header, const_cast<std::uint8_t*>(data),
                                  static_cast<int>(size));
}

}  // namespace omni::hil
