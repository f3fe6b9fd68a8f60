#include "service/monitor/web/access.h"

#include <sys/random.h>

#include <array>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <string>

namespace omni::monitor {
namespace {

constexpr std::string_view kBearer = "Bearer ", kCode = "Code ";
constexpr std::string_view kTokenPrefix = "token.";
constexpr std::string_view kHttp = "http://";

std::string_view Trimmed(std::string_view text) noexcept {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

}  // namespace

base::Result<std::string> MakeToken() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    return base::Error{"no random numbers from the system (getrandom): no token can be made for the page"};
  }
  std::string token;
  for (const unsigned char byte : bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    token += kDigits[byte >> 4];
    token += kDigits[byte & 15];
  }
  return token;
}

bool SameToken(std::string_view given, std::string_view token) noexcept {
  if (token.empty() || given.size() != token.size()) return false;
  int different = 0;
  for (std::size_t i = 0; i < token.size(); ++i) different |= given[i] ^ token[i];
  return different == 0;
}

bool HostAllowed(std::string_view host, std::uint16_t port) noexcept {
  const std::size_t colon = host.rfind(':');
  if (colon == std::string_view::npos) return false;
  const std::string_view name = host.substr(0, colon);
  if (host.substr(colon + 1) != std::to_string(port)) return false;
  return name == "127.0.0.1" || name == "localhost" || name == "[::1]";
}

bool OriginAllowed(std::string_view origin, std::uint16_t port) noexcept {
  return origin.substr(0, kHttp.size()) == kHttp && HostAllowed(origin.substr(kHttp.size()), port);
}

std::string_view BearerToken(std::string_view authorization) noexcept {
  if (authorization.substr(0, kBearer.size()) != kBearer) return {};
  return Trimmed(authorization.substr(kBearer.size()));
}

std::string_view OnceCode(std::string_view authorization) noexcept {
  if (authorization.substr(0, kCode.size()) != kCode) return {};
  return Trimmed(authorization.substr(kCode.size()));
}

std::string_view ProtocolToken(std::string_view protocols) noexcept {
  while (!protocols.empty()) {
    const std::size_t comma = protocols.find(',');
    const std::string_view word = Trimmed(protocols.substr(0, comma));
    if (word.substr(0, kTokenPrefix.size()) == kTokenPrefix) return word.substr(kTokenPrefix.size());
    protocols = comma == std::string_view::npos ? std::string_view() : protocols.substr(comma + 1);
  }
  return {};
}

namespace {

constexpr unsigned kLoopback = 0x0100007F;  // 127.0.0.1, as a little-endian machine prints it
constexpr unsigned kEstablished = 1, kCloseWait = 8;

}  // namespace

std::optional<uid_t> UserOfLoopback(std::uint16_t from, std::uint16_t to) {
  std::ifstream table("/proc/net/tcp");
  std::string row;
  std::getline(table, row);  // names
  while (std::getline(table, row)) {
    unsigned here = 0, here_port = 0, there = 0, there_port = 0, state = 0, user = 0;
    // sl local_address rem_address st tx_queue:rx_queue tr:tm->when retrnsmt uid
    const int read = std::sscanf(row.c_str(), "%*u: %8X:%4X %8X:%4X %2X %*8X:%*8X %*2X:%*8X %*8X %u", &here, &here_port,
                                 &there, &there_port, &state, &user);
    if (read != 6 || here != kLoopback || there != kLoopback || here_port != from || there_port != to) continue;
    if (state <= kEstablished || state == kCloseWait) return user;
  }
  return std::nullopt;
}

}  // namespace omni::monitor
