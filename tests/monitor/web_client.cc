#include "tests/monitor/web_client.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

namespace omni::monitor::test {
namespace {

constexpr int kQuietPumps = 60;  // so many calls without a byte: nothing more comes

}  // namespace

WebClient::WebClient(std::uint16_t port, std::function<void()> pump)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), pump_(std::move(pump)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  closed_ = ::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0;
  ::fcntl(socket_.get(), F_SETFL, O_NONBLOCK);
}

void WebClient::Send(std::string_view bytes) {
  while (!bytes.empty() && !closed_) {
    const ssize_t sent = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    if (sent <= 0 && errno != EAGAIN) closed_ = true;
    pump_();
  }
}

// False: nothing has come.
bool WebClient::Receive() {
  char bytes[65536];
  const ssize_t got = ::recv(socket_.get(), bytes, sizeof(bytes), 0);
  if (got > 0) received_.append(bytes, static_cast<std::size_t>(got));
  if (got == 0 || (got < 0 && errno != EAGAIN)) closed_ = true;
  return got > 0;
}

std::string WebClient::ReadAll() {
  for (int quiet = 0; quiet < kQuietPumps && !closed_; ++quiet) {
    pump_();
    if (Receive()) quiet = 0;
  }
  return std::exchange(received_, {});
}

std::string WebClient::Get(const std::string& target, const std::string& headers) {
  Send("GET " + target + " HTTP/1.1\r\n" + headers + "\r\n");
  return ReadAll();
}

std::string WebClient::Upgrade(const std::string& target, const std::string& headers) {
  Send("GET " + target + " HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n" +
       "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" + headers + "\r\n");
  std::size_t end = std::string::npos;
  for (int quiet = 0; quiet < kQuietPumps && end == std::string::npos && !closed_; ++quiet) {
    pump_();
    if (Receive()) quiet = 0;
    end = received_.find("\r\n\r\n");
  }
  if (end == std::string::npos) return received_;
  const std::string line = received_.substr(0, received_.find("\r\n"));
  received_.erase(0, end + 4);
  return line;
}

void WebClient::SendFrame(unsigned opcode, std::string_view payload, bool masked) {
  std::string frame(1, static_cast<char>(0x80 | opcode));
  const auto mask_bit = static_cast<unsigned char>(masked ? 0x80 : 0);
  if (payload.size() < 126) {
    frame += static_cast<char>(mask_bit | payload.size());
  } else {
    const bool small = payload.size() < 65536;
    frame += static_cast<char>(mask_bit | (small ? 126 : 127));
    for (int shift = small ? 8 : 56; shift >= 0; shift -= 8)
      frame += static_cast<char>(std::uint64_t{payload.size()} >> shift);
  }
  constexpr unsigned char kMask[4] = {0x12, 0x34, 0x56, 0x78};
  if (masked) frame.append(reinterpret_cast<const char*>(kMask), 4);
  for (std::size_t i = 0; i < payload.size(); ++i) {
    frame += static_cast<char>(masked ? payload[i] ^ kMask[i % 4] : payload[i]);
  }
  Send(frame);
}

WebClient::Frame WebClient::ReadFrame() {
  const auto byte = [this](std::size_t i) {
    return static_cast<std::uint64_t>(static_cast<unsigned char>(received_[i]));
  };
  for (int quiet = 0; quiet < kQuietPumps; ++quiet) {
    std::size_t head = 2;
    std::uint64_t size = received_.size() < 2 ? 0 : byte(1) & 0x7f;
    if (size >= 126) {
      const std::size_t bytes = size == 126 ? 2 : 8;
      head += bytes;
      size = 0;
      for (std::size_t i = 2; i < head && received_.size() >= head; ++i) size = size << 8 | byte(i);
    }
    if (received_.size() >= head && received_.size() >= head + size) {
      Frame frame{static_cast<unsigned>(byte(0) & 0x0f), received_.substr(head, size)};
      received_.erase(0, head + size);
      return frame;
    }
    if (closed_) break;
    pump_();
    if (Receive()) quiet = 0;
  }
  return {};
}

}  // namespace omni::monitor::test
