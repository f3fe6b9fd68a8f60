#include "service/haptics/sculpt/mesh/edit_step.h"

#include <algorithm>

namespace omni::haptics::sculpt {
namespace {

const PageContent& Zeros() noexcept {
  static const PageContent zeros{};
  return zeros;
}

}  // namespace

void AppendRuns(std::uint32_t page, const PageContent& before, const PageContent& after, UndoStep& step) {
  const std::uint64_t header = std::uint64_t{page} << 32;
  bool any = false;
  for (std::size_t word = 0; word < kContentWords;) {
    if (WordOf(before, word) == WordOf(after, word)) {
      ++word;
      continue;
    }
    const std::size_t at = step.words.size(), first = word;
    step.words.push_back(0);
    for (; word < kContentWords; ++word) {
      const std::uint64_t change = WordOf(before, word) ^ WordOf(after, word);
      if (change == 0) break;
      step.words.push_back(change);
    }
    step.words[at] = header | std::uint64_t{first} << 16 | (word - first);
    any = true;
  }
  if (!any) step.words.push_back(header);
}

bool IsWellFormed(const UndoStep& step, std::uint32_t& pages) noexcept {
  const std::uint32_t most = std::min(kMaxPages, pages + kMaxNewPages);
  for (std::size_t i = 0; i < step.words.size();) {
    const StepRun run = RunOf(step.words[i++]);
    if (run.page >= most || run.first + run.count > kContentWords || run.count > step.words.size() - i) return false;
    pages = std::max(pages, run.page + 1);
    i += run.count;
  }
  return true;
}

void StepSum::Add(const UndoStep& step) {
  for (std::size_t i = 0; i < step.words.size();) {
    const StepRun run = RunOf(step.words[i++]);
    PageContent& content = changed_.try_emplace(run.page, Zeros()).first->second;
    for (std::size_t k = 0; k < run.count; ++k) FlipWord(content, run.first + k, step.words[i++]);
  }
}

UndoStep StepSum::Take() const {
  UndoStep step;
  for (const auto& [page, content] : changed_) AppendRuns(page, Zeros(), content, step);
  return step;
}

}  // namespace omni::haptics::sculpt
