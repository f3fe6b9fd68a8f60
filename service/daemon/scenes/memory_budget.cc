#include "service/daemon/scenes/memory_budget.h"

#include <algorithm>

namespace omni::daemon {
namespace {

std::string Megabytes(std::uint64_t bytes) { return std::to_string(bytes / kMB + (bytes % kMB > 0 ? 1 : 0)) + " MB"; }

std::uint64_t Left(std::uint64_t limit, std::uint64_t used) { return limit > used ? limit - used : 0; }

constexpr const char* kSimplify = "simplify the model, or tag only what is touched";

}  // namespace

MemoryBudget::Number MemoryBudget::Wait(const BuildRequest& request) {
  waiting_.emplace(++newest_, Waiting{.request = request});
  return newest_;
}

// Of kept and promised memory, without what the request replaces.
std::uint64_t MemoryBudget::OthersKept(const BuildRequest& request, Number itself, bool of_payer) const {
  std::uint64_t sum = 0;
  for (const auto& [number, kept] : kept_) {
    if (of_payer && kept.payer != request.payer) continue;
    if (kept.job != request.job || request.soft) sum += kept.bytes;
  }
  for (const auto& [number, other] : running_) {
    if (number != itself && (!of_payer || other.payer == request.payer)) sum += other.need.kept_bytes;
  }
  return sum;
}

std::uint64_t MemoryBudget::OthersPeak(Number itself) const {
  std::uint64_t sum = 0;
  for (const auto& [number, other] : running_) sum += number == itself ? 0 : other.need.peak_bytes;
  return sum;
}

// What is replaced stays until the tick has given it up. Until then the pool is smaller by what is kept beyond the
// limit: a finished build has left it more than that.
MemoryBudget::Lack MemoryBudget::LackOf(const BuildRequest& request, Number itself) const {
  const bool runs = running_.contains(itself);
  const auto soft = static_cast<std::size_t>(
      std::count_if(running_.begin(), running_.end(), [](const auto& other) { return other.second.soft; }));
  if (!runs && running_.size() >= limits_.builders) return Lack::kBuilder;
  if (!runs && request.soft && soft + 1 >= limits_.builders) return Lack::kBuilder;
  if (request.need.kept_bytes > Left(limits_.kept_bytes, OthersKept(request, itself, false))) return Lack::kKept;
  const std::uint64_t beyond = Left(kept_bytes(), limits_.kept_bytes);
  if (request.need.peak_bytes > Left(limits_.pool_bytes, OthersPeak(itself) + beyond)) return Lack::kPool;
  return Lack::kNothing;
}

// An earlier one that has waited long enough for the pool keeps all later ones back. One that waits until others give
// up their scenes does not: nothing that is started here delays that.
bool MemoryBudget::MayOvertake(Number request) const {
  for (const auto& [number, earlier] : waiting_) {
    if (number >= request) break;
    if (earlier.overtaken >= kMostOvertaken && LackOf(earlier.request, number) == Lack::kPool) return false;
  }
  return true;
}

void MemoryBudget::CountOvertaken(Number request) {
  for (auto& [number, earlier] : waiting_) {
    if (number >= request) break;
    if (!earlier.request.soft) ++earlier.overtaken;
  }
}

std::optional<MemoryBudget::Number> MemoryBudget::StartNext() {
  for (const bool soft : {false, true}) {
    for (auto& [number, waiting] : waiting_) {
      if (waiting.request.soft != soft) continue;
      if (LackOf(waiting.request, number) != Lack::kNothing || !MayOvertake(number)) continue;
      const Number started = number;
      running_.emplace(started, waiting.request);
      waiting_.erase(started);
      CountOvertaken(started);
      return started;
    }
  }
  return std::nullopt;
}

MemoryBudget::Answer MemoryBudget::Grow(Number request, const scene::BuildNeed& need, std::string& why) {
  BuildRequest grown = running_.at(request);
  grown.need.kept_bytes = std::max(grown.need.kept_bytes, need.kept_bytes);
  grown.need.peak_bytes = std::max(grown.need.peak_bytes, need.peak_bytes);
  why = WhyRefused(grown, request);
  if (!why.empty()) return Answer::kRefused;
  const BuildRequest& now = running_.at(request);
  const bool more = grown.need.peak_bytes > now.need.peak_bytes || grown.need.kept_bytes > now.need.kept_bytes;
  if (more && (LackOf(grown, request) != Lack::kNothing || !MayOvertake(request))) {
    running_.erase(request);
    waiting_.emplace(request, Waiting{.request = grown});
    why = WhyItWaits(request);
    return Answer::kWaits;
  }
  running_.at(request) = grown;
  return Answer::kGranted;
}

MemoryBudget::Number MemoryBudget::Finish(Number request, std::uint64_t bytes) {
  const BuildRequest& ended = running_.at(request);
  kept_.emplace(++newest_, Kept{ended.job, ended.payer, bytes});
  running_.erase(request);
  return newest_;
}

void MemoryBudget::FinishInto(Number request, Number kept, std::uint64_t bytes) {
  running_.erase(request);
  if (const auto found = kept_.find(kept); found != kept_.end()) found->second.bytes += bytes;
}

void MemoryBudget::End(Number request) {
  waiting_.erase(request);
  running_.erase(request);
}

void MemoryBudget::FreeKept(Number kept) { kept_.erase(kept); }

std::uint64_t MemoryBudget::RoomFor(Number request) const {
  const BuildRequest& now = running_.at(request);
  const std::uint64_t granted = now.need.kept_bytes;
  return std::min(Left(limits_.client_bytes, OthersKept(now, request, true) + granted),
                  Left(limits_.kept_bytes, OthersKept(now, request, false) + granted));
}

std::string MemoryBudget::WhyRefused(const BuildRequest& request, Number itself) const {
  const scene::BuildNeed& need = request.need;
  if (need.peak_bytes > limits_.pool_bytes) {
    return "needs " + Megabytes(need.peak_bytes) + " while it is built, the limit is " + Megabytes(limits_.pool_bytes) +
           "; " + kSimplify;
  }
  const std::uint64_t has = OthersKept(request, itself, true);
  const std::uint64_t limit = std::min(limits_.client_bytes, limits_.kept_bytes);
  if (need.kept_bytes <= Left(limit, has)) return {};
  std::string text =
      "needs " + Megabytes(need.kept_bytes) + ", a client may have " + Megabytes(limit) + " of built scenes";
  if (has > 0) text += " and has " + Megabytes(has) + " of others";
  return text + "; " + kSimplify;
}

scene::BuildNeed MemoryBudget::NeedOf(Number request) const {
  if (const auto found = waiting_.find(request); found != waiting_.end()) return found->second.request.need;
  const auto found = running_.find(request);
  return found == running_.end() ? scene::BuildNeed{} : found->second.need;
}

std::string MemoryBudget::WhyItWaits(Number request) const {
  const auto found = waiting_.find(request);
  if (found == waiting_.end()) return {};
  const BuildRequest& wanted = found->second.request;
  const auto needs = [](std::uint64_t bytes, std::uint64_t free) {
    return "waits for memory: needs " + Megabytes(bytes) + ", " + std::to_string(free / kMB) + " MB are free";
  };
  switch (LackOf(wanted, request)) {
    case Lack::kBuilder:
      return "waits: " + std::to_string(running_.size()) + " others are being built";
    case Lack::kKept:
      return needs(wanted.need.kept_bytes, Left(limits_.kept_bytes, OthersKept(wanted, request, false))) +
             " until other applications end";
    case Lack::kPool:
      return needs(wanted.need.peak_bytes,
                   Left(limits_.pool_bytes, peak_bytes() + Left(kept_bytes(), limits_.kept_bytes)));
    case Lack::kNothing:
      break;
  }
  return "waits for those that came before";
}

std::uint64_t MemoryBudget::kept_bytes() const {
  std::uint64_t sum = 0;
  for (const auto& [number, kept] : kept_) sum += kept.bytes;
  return sum;
}

std::uint64_t MemoryBudget::kept_bytes(std::uint64_t payer) const {
  std::uint64_t sum = 0;
  for (const auto& [number, kept] : kept_) sum += kept.payer == payer ? kept.bytes : 0;
  return sum;
}

std::uint64_t MemoryBudget::peak_bytes() const { return OthersPeak(0); }

}  // namespace omni::daemon
