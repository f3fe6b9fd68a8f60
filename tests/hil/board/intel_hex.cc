#include "tests/hil/board/intel_hex.h"

#include <sstream>
#include <vector>

namespace omni::hil {
namespace {

enum RecordType { kData = 0, kEnd = 1, kUpperAddress = 4, kStart = 5 };

int Digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

// The bytes of ":LLAAAATT...CC"; none: not such a line, or a wrong checksum.
std::vector<std::uint8_t> RecordOf(const std::string& line) {
  std::vector<std::uint8_t> bytes;
  std::uint8_t sum = 0;
  if (line.size() < 11 || line.size() % 2 == 0 || line[0] != ':') return {};
  for (std::size_t i = 1; i < line.size(); i += 2) {
    const int high = Digit(line[i]), low = Digit(line[i + 1]);
    if (high < 0 || low < 0) return {};
    bytes.push_back(static_cast<std::uint8_t>(high * 16 + low));
    sum = static_cast<std::uint8_t>(sum + bytes.back());
  }
  return sum == 0 && bytes.size() == bytes[0] + 5U ? bytes : std::vector<std::uint8_t>();
}

}  // namespace

std::map<std::uint32_t, std::uint8_t> ReadIntelHex(const std::string& text, std::string& error) {
  std::map<std::uint32_t, std::uint8_t> memory;
  std::istringstream lines(text);
  std::string line;
  std::uint32_t upper = 0;
  bool ended = false;
  error.clear();
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::vector<std::uint8_t> record = RecordOf(line);
    if (record.empty() || ended) {
      error = "line " + std::to_string(number) + (ended ? ": behind the end" : ": no record: ") + (ended ? "" : line);
      return memory;
    }
    const std::uint32_t offset = static_cast<std::uint32_t>(record[1] << 8 | record[2]);
    if (record[3] == kUpperAddress)
      upper = static_cast<std::uint32_t>(record[4]) << 24 | static_cast<std::uint32_t>(record[5]) << 16;
    if (record[3] == kEnd) ended = true;
    if (record[3] != kData) continue;
    for (std::uint32_t i = 0; i < record[0]; ++i) {
      if (!memory.emplace(upper + offset + i, record[4 + i]).second)
        error = "line " + std::to_string(number) + ": a byte twice";
    }
  }
  if (!ended && error.empty()) error = "no end record";
  return memory;
}

}  // namespace omni::hil
