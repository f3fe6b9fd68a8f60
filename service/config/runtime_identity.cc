#include "service/config/runtime_identity.h"

#include <algorithm>

namespace omni::config {
namespace {

constexpr std::string_view kSpaces = " \t\r\n";

bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsHexDigit(char c) { return IsDigit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }

// Up to the first quotation mark that begins a word.
std::string_view BeforeQuotation(std::string_view name) {
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool begins_word = i == 0 || kSpaces.find(name[i - 1]) != std::string_view::npos;
    if (begins_word && (name[i] == '\'' || name[i] == '"')) return name.substr(0, i);
  }
  return name;
}

// 5976596, g5976596: letters alone are a word.
bool IsGitHash(std::string_view word) {
  if (word.size() > 1 && word.front() == 'g') word.remove_prefix(1);
  return word.size() >= 7 && word.size() <= 40 && std::all_of(word.begin(), word.end(), IsHexDigit) &&
         std::any_of(word.begin(), word.end(), IsDigit);
}

// 1.2, v1, v1.2-rc3: digits alone may belong to a product's name.
bool IsVersion(std::string_view word) {
  const bool marked = !word.empty() && (word.front() == 'v' || word.front() == 'V');
  if (marked) word.remove_prefix(1);
  const auto end = std::find_if_not(word.begin(), word.end(), IsDigit);
  if (end == word.begin()) return false;
  if (end == word.end() || *end == '-' || *end == '+') return marked;
  return *end == '.' && end + 1 != word.end() && IsDigit(*(end + 1));
}

std::string_view WithoutBrackets(std::string_view word) {
  if (word.size() > 2 && (word.front() == '(' || word.front() == '[')) word.remove_prefix(1);
  while (!word.empty() && std::string_view(")],;").find(word.back()) != std::string_view::npos) word.remove_suffix(1);
  return word;
}

}  // namespace

std::string RuntimeIdentity(std::string_view runtime_name) {
  std::string_view rest = BeforeQuotation(runtime_name);
  rest = rest.substr(0, rest.find(" by "));
  std::string identity;
  while (true) {
    rest.remove_prefix(std::min(rest.find_first_not_of(kSpaces), rest.size()));
    if (rest.empty()) break;
    const std::string_view word = rest.substr(0, rest.find_first_of(kSpaces));
    rest.remove_prefix(word.size());
    const std::string_view bare = WithoutBrackets(word);
    if (IsVersion(bare) || IsGitHash(bare)) continue;
    if (!identity.empty()) identity += ' ';
    identity += word;
  }
  identity.erase(identity.find_last_not_of(" ,:;-") + 1);
  return identity.empty() ? std::string(runtime_name) : identity;
}

}  // namespace omni::config
