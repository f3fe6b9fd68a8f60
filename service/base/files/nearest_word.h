// Suggests the word probably meant by a mistyped one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace omni::base {

// Insertions, deletions, replacements and swaps of neighbours that turn one word into the other, each place changed
// once ("optimal string alignment"); capitals count as small letters.
inline std::size_t EditDistance(std::string_view a, std::string_view b) {
  const auto same = [](char x, char y) {
    const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    return small(x) == small(y);
  };
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last.swap(last);
    last.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

// The nearest of `known` (a range of strings), the first of equally near ones; empty: none is near. Near: at most a
// third of the longer word differs, or the word is a prefix of at least three letters.
template <class Words>
std::string NearestWord(std::string_view word, const Words& known) {
  std::string nearest;
  std::size_t least = word.size() + 1;
  for (const auto& entry : known) {
    const std::string_view candidate(entry);
    const std::size_t longer = std::max(word.size(), candidate.size()),
                      shorter = std::min(word.size(), candidate.size());
    const std::size_t allowed = std::max<std::size_t>(1, longer / 3);
    const bool begins = word.size() >= 3 && candidate.substr(0, word.size()) == word;
    if (!begins && longer - shorter > allowed) continue;
    const std::size_t distance = begins ? 1 : EditDistance(word, candidate);
    if (distance > allowed || distance >= least) continue;
    nearest = candidate;
    least = distance;
  }
  return nearest;
}

// "; did you mean 'status'?", or nothing where no word is near.
template <class Words>
std::string DidYouMean(std::string_view word, const Words& known) {
  const std::string nearest = NearestWord(word, known);
  return nearest.empty() ? std::string() : "; did you mean '" + nearest + "'?";
}

}  // namespace omni::base
