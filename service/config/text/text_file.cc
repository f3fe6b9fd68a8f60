#include "service/config/text/text_file.h"

#include <algorithm>

#include "service/base/files/whole_file.h"

namespace omni::config {
namespace {

// Where a text that begins with a quote ends: after its closing quotes, or at the end of a line that lacks them, where
// toml++ stops.
std::size_t EndOfString(std::string_view text, std::size_t begin, std::size_t& line) {
  const char quote = text[begin];
  const bool several_lines = text.substr(begin, 3) == std::string(3, quote);
  for (std::size_t i = begin + (several_lines ? 3 : 1); i < text.size(); ++i) {
    if (text[i] == '\n') {
      if (!several_lines) return i;
      ++line;
    } else if (text[i] == '\\' && quote == '"') {
      if (i + 1 < text.size() && text[i + 1] != '\n') ++i;
    } else if (text[i] == quote) {
      if (!several_lines) return i + 1;
      // Three close it; up to two before them belong to the text.
      std::size_t quotes = 1;
      while (quotes < 5 && text.substr(i + quotes, 1) == std::string_view(&quote, 1)) ++quotes;
      if (quotes >= 3) return i + quotes;
      i += quotes - 1;
    }
  }
  return text.size();
}

class Scan {
 public:
  Scan(std::string_view text, const TomlLimits& limits) : text_(text), limits_(limits) {}

  // The exceeded limit; empty: none.
  std::string Run() {
    for (std::size_t i = 0; i < text_.size() && problem_.empty();) i = Step(i);
    return problem_;
  }
  std::size_t line() const { return line_; }

 private:
  // Reads the token at i; returns its end.
  std::size_t Step(std::size_t i) {
    const char c = text_[i];
    if (c == '#') return std::min(text_.find('\n', i), text_.size());
    if (c == '"' || c == '\'') {
      word_ = 0;
      return EndOfString(text_, i, line_);
    }
    constexpr std::string_view kEndsWord = " \t\r\n.,=[]{}";
    word_ = kEndsWord.find(c) == kEndsWord.npos ? word_ + 1 : 0;
    if (word_ > limits_.word) Refuse("a word of more than ", limits_.word, " bytes");
    if (c == '.') {
      if (++parts_ > limits_.parts) Refuse("a key of more than ", limits_.parts, " parts");
    } else if (c != ' ' && c != '\t' && word_ == 0) {
      parts_ = 1;
    }
    if (c == '[' || c == '{') {
      if (++depth_ > limits_.depth) Refuse("arrays or tables nested deeper than ", limits_.depth, " levels");
    }
    if ((c == ']' || c == '}') && depth_ > 0) --depth_;
    if (c == '=' || c == ',' || c == '[') {
      if (++values_ > limits_.values) Refuse("more than ", limits_.values, " values");
    }
    if (c == '\n') ++line_;
    return i + 1;
  }

  void Refuse(const char* what, std::size_t limit, const char* of) {
    problem_ = "has " + std::string(what) + std::to_string(limit) + of +
               ", which no settings file needs; check that this is the right file";
  }

  const std::string_view text_;
  const TomlLimits limits_;
  std::string problem_;
  std::size_t line_ = 1, depth_ = 0, parts_ = 1, word_ = 0, values_ = 0;
};

}  // namespace

base::Result<std::string> ReadTextFile(const std::string& path) { return base::ReadFile(path, kMaxSettingsBytes); }

base::Status WriteTextFile(const std::string& path, const std::string& text) {
  return base::WriteWholeFile(path, text, {.make_folder = true});
}

base::Status CheckToml(std::string_view text, const std::string& file, const TomlLimits& limits) {
  if (text.size() > limits.bytes) {
    return base::Error{file + ": is longer than " + std::to_string(limits.bytes) +
                       " bytes, which no settings file needs; check that this is the right file"};
  }
  Scan scan(text, limits);
  const std::string problem = scan.Run();
  if (!problem.empty()) return base::Error{file + ":" + std::to_string(scan.line()) + ": " + problem};
  return base::Ok{};
}

}  // namespace omni::config
