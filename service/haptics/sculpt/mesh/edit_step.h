// What one edit changed, as words: turns the pages before it into those after it, and back. It can be kept in a file,
// so what it says may come from anywhere.
#pragma once

#include <cstring>
#include <map>
#include <vector>

#include "service/haptics/sculpt/mesh/page.h"

namespace omni::haptics::sculpt {

// Runs of 64-bit words, each the old exclusive-or the new. A run is one header word (page << 32 | first word << 16 |
// words) and its words; a header without words names a page whose triangles have moved with vertices of other pages.
struct UndoStep {
  std::vector<std::uint64_t> words;
  std::size_t bytes() const noexcept { return words.size() * sizeof(std::uint64_t); }
  bool operator==(const UndoStep&) const = default;
};

inline constexpr std::size_t kContentWords = sizeof(PageContent) / sizeof(std::uint64_t);
static_assert(kContentWords < 0x10000);

inline std::uint64_t WordOf(const PageContent& content, std::size_t word) noexcept {
  std::uint64_t value = 0;
  std::memcpy(&value, reinterpret_cast<const std::byte*>(&content) + sizeof(value) * word, sizeof(value));
  return value;
}

inline void FlipWord(PageContent& content, std::size_t word, std::uint64_t change) noexcept {
  const std::uint64_t value = WordOf(content, word) ^ change;
  std::memcpy(reinterpret_cast<std::byte*>(&content) + sizeof(value) * word, &value, sizeof(value));
}

struct StepRun {
  std::uint32_t page = 0;
  std::size_t first = 0, count = 0;  // words of the page
};
inline StepRun RunOf(std::uint64_t header) noexcept {
  return {static_cast<std::uint32_t>(header >> 32), header >> 16 & 0xFFFF, header & 0xFFFF};
}

// Appends the runs in which two states of a page differ.
void AppendRuns(std::uint32_t page, const PageContent& before, const PageContent& after, UndoStep& step);

// Pages that a step may add beyond those there are: strokes that were refused leave empty ones behind.
inline constexpr std::uint32_t kMaxNewPages = 1024;

// Whether every run lies within a page, and every page is one of the first `pages` or could have been added to them;
// `pages` then counts those too.
bool IsWellFormed(const UndoStep& step, std::uint32_t& pages) noexcept;

// Several steps as one. Order does not matter.
class StepSum {
 public:
  // Precondition: IsWellFormed.
  void Add(const UndoStep& step);
  UndoStep Take() const;

 private:
  std::map<std::uint32_t, PageContent> changed_;
};

}  // namespace omni::haptics::sculpt
