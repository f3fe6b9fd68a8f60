#include "service/daemon/log_queue.h"

#include <algorithm>
#include <utility>

namespace omni::daemon {
namespace {

constexpr std::size_t kPatternMax = 160;  // characters that distinguish kinds

std::string PatternOf(std::string_view line) {
  std::string pattern;
  char quote = 0;  // that is open
  for (const char c : line.substr(0, kPatternMax)) {
    const bool was_open = quote != 0;
    if (c == quote) {
      quote = 0;
    } else if (!was_open && (c == '"' || c == '\'')) {
      quote = c;
    }
    if (!was_open && !(c >= '0' && c <= '9')) pattern += c;
  }
  return pattern;
}

std::string MoreText(std::uint64_t more, std::int64_t since_ns, std::int64_t now_ns) {
  const std::int64_t seconds = std::max<std::int64_t>(1, (now_ns - since_ns + 500'000'000) / 1'000'000'000);
  return " (" + std::to_string(more) + " more of these in the last " + std::to_string(seconds) + " s)";
}

}  // namespace

LineLimit::LineLimit() : kinds_(1) {}

void LineLimit::Fill(Kind& kind, std::int64_t now_ns) {
  const std::int64_t due = std::max<std::int64_t>(0, now_ns - kind.filled_ns) / kPeriod_ns;
  if (due == 0) return;
  kind.tokens = static_cast<int>(std::min<std::int64_t>(kBurst, kind.tokens + due));
  kind.filled_ns += due * kPeriod_ns;
}

LineLimit::Kind& LineLimit::KindOf(std::string_view line, std::int64_t now_ns) {
  std::string pattern = PatternOf(line);
  Kind* free = nullptr;
  for (auto kind = kinds_.begin() + 1; kind != kinds_.end(); ++kind) {
    Fill(*kind, now_ns);
    if (kind->pattern == pattern) return *kind;
    if (kind->idle()) free = &*kind;
  }
  if (free == nullptr && kinds_.size() <= kMaxKinds) free = &kinds_.emplace_back();
  if (free == nullptr) {
    Fill(kinds_.front(), now_ns);
    return kinds_.front();
  }
  *free = {.pattern = std::move(pattern), .filled_ns = now_ns};
  return *free;
}

void LineLimit::Add(std::string_view line, std::int64_t now_ns, std::string& out) {
  Kind& kind = KindOf(line, now_ns);
  if (kind.tokens == 0) {
    if (kind.held_back++ == 0) kind.since_ns = now_ns;
    kind.newest = line;
    return;
  }
  --kind.tokens;
  out += line;
  if (kind.held_back > 0) out += MoreText(std::exchange(kind.held_back, 0), kind.since_ns, now_ns);
  out += '\n';
}

void LineLimit::ReportOne(Kind& kind, std::int64_t now_ns, std::string& out) {
  const std::uint64_t more = std::exchange(kind.held_back, 0) - 1;
  out += kind.newest;
  if (more > 0) out += MoreText(more, kind.since_ns, now_ns);
  out += '\n';
}

void LineLimit::AppendDueLines(std::int64_t now_ns, std::string& out) {
  for (Kind& kind : kinds_) {
    Fill(kind, now_ns);
    if (kind.held_back == 0 || kind.tokens == 0) continue;
    --kind.tokens;
    ReportOne(kind, now_ns, out);
  }
}

void LineLimit::ReportAll(std::int64_t now_ns, std::string& out) {
  for (Kind& kind : kinds_) {
    if (kind.held_back > 0) ReportOne(kind, now_ns, out);
  }
}

bool LineLimit::holds_back() const {
  return std::any_of(kinds_.begin(), kinds_.end(), [](const Kind& kind) { return kind.held_back > 0; });
}

}  // namespace omni::daemon
