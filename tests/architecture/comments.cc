#include "tests/architecture/comments.h"

#include <algorithm>
#include <cctype>

namespace omni::architecture {
namespace {

bool IsWord(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// One past the string or character that begins at `at`; a ' within a number separates digits.
std::size_t EndOfLiteral(const std::string& text, std::size_t at) {
  const char quote = text[at];
  if (quote == '"' && at > 0 && text[at - 1] == 'R') {
    const std::size_t open = text.find('(', at);
    if (open == std::string::npos) return text.size();
    const std::string close = ")" + text.substr(at + 1, open - at - 1) + "\"";
    const std::size_t end = text.find(close, open);
    return end == std::string::npos ? text.size() : end + close.size();
  }
  if (quote == '\'' && at > 0 && IsWord(text[at - 1])) return at + 1;
  for (++at; at < text.size(); ++at) {
    if (text[at] == '\\')
      ++at;
    else if (text[at] == quote || (text[at] == '\n' && quote != '`'))
      return at + 1;
  }
  return text.size();
}

struct Reader {
  const std::string& text;
  Source source;
  std::size_t at = 0;
  int line = 1;
  int last_line = -1;       // where the comment before ended
  bool is_alone = true;     // nothing but space on this line yet
  bool last_alone = false;  // nothing but the comment before on its line

  void Comment(std::size_t end) {
    const std::string words = text.substr(at + 2, end - at - 2);
    if (is_alone && last_alone && last_line == line - 1)
      source.comments.back().text += "\n" + words;
    else
      source.comments.push_back({line, words});
    line += static_cast<int>(std::count(words.begin(), words.end(), '\n'));
    last_line = line;
    last_alone = is_alone;
    at = end;
  }

  void Code(std::size_t end) {
    for (; at < end; ++at) {
      const char c = text[at];
      source.code += c;
      line += c == '\n' ? 1 : 0;
      is_alone = c == '\n' || (is_alone && std::isspace(static_cast<unsigned char>(c)) != 0);
    }
  }

  void Run() {
    while (at < text.size()) {
      const char c = text[at];
      if (text.compare(at, 2, "//") == 0) {
        Comment(std::min(text.find('\n', at), text.size()));
      } else if (text.compare(at, 2, "/*") == 0) {
        const std::size_t end = text.find("*/", at + 2);
        Comment(end == std::string::npos ? text.size() : end);
        at = std::min(at + 2, text.size());
      } else {
        Code(c == '"' || c == '\'' || c == '`' ? EndOfLiteral(text, at) : at + 1);
      }
    }
  }
};

}  // namespace

Source ReadSource(const std::string& text) {
  Reader reader{text, {}};
  reader.Run();
  return reader.source;
}

}  // namespace omni::architecture
