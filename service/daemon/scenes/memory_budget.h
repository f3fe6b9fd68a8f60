// Memory for scenes: how much of it is kept, how much builders use meanwhile, and which of those that wait is next.
// Numbers only: no thread, no lock, no memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "service/scene/load_scene.h"

namespace omni::daemon {

inline constexpr std::uint64_t kMB = 1'000'000;

// With what omnid itself takes, below the limit of manifests/systemd/omnid.service.in (tests/daemon/memory_budget.cc
// compares, with docs/scenes.md too).
struct MemoryLimits {
  std::uint64_t client_bytes = 256 * kMB;  // of built scenes, for each client
  std::uint64_t kept_bytes = 768 * kMB;    // of built scenes, for all
  std::uint64_t pool_bytes = 1200 * kMB;   // of builders that run, together
  std::uint32_t builders = 2;              // at once, at least 2; soft bodies leave one of them to scenes
};

struct BuildRequest {
  std::uint64_t job = 0;    // the scene replaces what is kept of the same job
  std::uint64_t payer = 0;  // client
  bool soft = false;        // a soft body: added to its scene, and started when no scene can be
  scene::BuildNeed need;    // as far as it is known
};

class MemoryBudget {
 public:
  using Number = std::uint64_t;  // of a request, or of what is kept; counts up from 1

  explicit MemoryBudget(const MemoryLimits& limits) : limits_(limits) {}
  const MemoryLimits& limits() const { return limits_; }

  // A request waits until StartNext returns it, and runs until Finish or End. Those that came first go first; a later
  // one that has room may go before one that has not, but after kMostOvertaken of them nothing does any more.
  static constexpr std::uint32_t kMostOvertaken = 16;
  Number Wait(const BuildRequest& request);
  std::optional<Number> StartNext();

  // The need of a running request has become known, or more of it. kWaits: it is back at its place in the queue.
  // kRefused: it will never have room while its client keeps what it has; `why` says so, with what to do.
  enum class Answer { kGranted, kWaits, kRefused };
  Answer Grow(Number request, const scene::BuildNeed& need, std::string& why);

  // A running request ends with something to keep, for which there is room: what it was granted, or RoomFor.
  Number Finish(Number request, std::uint64_t bytes);
  void FinishInto(Number request, Number kept, std::uint64_t bytes);
  void End(Number request);  // waiting or running: nothing is kept of it
  void FreeKept(Number kept);

  // What a running request may keep beyond what was granted.
  std::uint64_t RoomFor(Number request) const;

  bool IsWaiting(Number request) const { return waiting_.contains(request); }
  scene::BuildNeed NeedOf(Number request) const;  // of one that waits or runs
  // Why a request waits, for people; empty: it does not.
  std::string WhyItWaits(Number request) const;
  // Why it is never started; empty: it may be.
  std::string WhyRefused(const BuildRequest& request) const { return WhyRefused(request, 0); }

  std::uint64_t kept_bytes() const;
  std::uint64_t kept_bytes(std::uint64_t payer) const;
  std::uint64_t peak_bytes() const;  // of those that run
  std::size_t running() const { return running_.size(); }
  std::size_t waiting() const { return waiting_.size(); }

 private:
  struct Waiting {
    BuildRequest request;
    std::uint32_t overtaken = 0;
  };
  struct Kept {
    std::uint64_t job = 0, payer = 0, bytes = 0;
  };
  // What a request lacks now.
  enum class Lack { kNothing, kBuilder, kPool, kKept };
  Lack LackOf(const BuildRequest& request, Number itself) const;
  std::string WhyRefused(const BuildRequest& request, Number itself) const;
  std::uint64_t OthersKept(const BuildRequest& request, Number itself, bool of_payer) const;
  std::uint64_t OthersPeak(Number itself) const;
  bool MayOvertake(Number request) const;
  void CountOvertaken(Number request);

  const MemoryLimits limits_;
  Number newest_ = 0;
  std::map<Number, Waiting> waiting_;
  std::map<Number, BuildRequest> running_;
  std::map<Number, Kept> kept_;
};

}  // namespace omni::daemon
