#include "service/monitor/web/peer_user.h"

#include <cstdio>
#include <fstream>
#include <string>

namespace omni::monitor {
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
