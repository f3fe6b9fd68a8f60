#include "service/console/wrap.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace omni::console {
namespace {

constexpr int kLeastColumns = 20;
constexpr int kMostColumns = 10'000;
constexpr std::size_t kContinued = 2;  // indent of what continues a line without columns

// In code points: each is taken for one column.
std::size_t WidthOf(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::size_t SpacesAt(std::string_view line, std::size_t at) {
  return std::min(line.find_first_not_of(' ', at), line.size()) - at;
}

// Where what continues `line` begins.
std::size_t HangOf(std::string_view line, std::size_t columns) {
  const std::size_t indent = SpacesAt(line, 0);
  std::size_t hang = indent > 0 ? indent : kContinued;
  for (std::size_t at = line.find("  ", indent); at != line.npos; at = line.find("  ", at)) {
    at += SpacesAt(line, at);
    const std::size_t column = WidthOf(line.substr(0, at));
    if (column > columns / 2) break;
    hang = column;
  }
  return hang <= columns / 2 ? hang : kContinued;
}

std::string WrapLine(std::string_view line, std::size_t columns) {
  const std::size_t hang = HangOf(line, columns);
  std::string text;
  std::size_t used = 0;  // of the line that is being written
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t spaces = SpacesAt(line, at);
    const std::size_t begin = at + spaces, end = std::min(line.find(' ', begin), line.size());
    const std::string_view word = line.substr(begin, end - begin);
    at = end;
    if (word.empty()) break;  // spaces at its end
    if (used > 0 && used + spaces + WidthOf(word) > columns) {
      text += "\n" + std::string(hang, ' ');
      used = hang;
    } else {
      const std::size_t indent = used == 0 && spaces > columns / 2 ? hang : spaces;
      text += std::string(indent, ' ');
      used += indent;
    }
    text += word;
    used += WidthOf(word);
  }
  return text;
}

}  // namespace

TerminalSize SizeOfTerminal(int fd) {
  winsize size{};
  if (::ioctl(fd, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
  return {.columns = size.ws_col, .rows = size.ws_row};
}

int TextColumns(int fd) {
  int columns = 0;
  if (const char* value = std::getenv("COLUMNS"); value != nullptr) {
    const char* end = value + std::strlen(value);
    const auto parsed = std::from_chars(value, end, columns);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !(columns > 0 && columns <= kMostColumns)) columns = 0;
  }
  if (columns == 0 && ::isatty(fd) == 1) columns = SizeOfTerminal(fd).columns;
  return columns == 0 ? 0 : std::max(columns, kLeastColumns);
}

std::string Joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string Wrap(const std::string& text, int columns) {
  if (columns <= 0) return text;
  const auto width = static_cast<std::size_t>(columns);
  std::string wrapped;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = std::string_view(text).substr(at, end - at);
    wrapped += WidthOf(line) <= width ? std::string(line) : WrapLine(line, width);
    if (end < text.size()) wrapped += '\n';
    at = end + 1;
  }
  return wrapped;
}

std::string ForPeople(const std::string& text, int fd) { return Wrap(text, TextColumns(fd)); }

}  // namespace omni::console
