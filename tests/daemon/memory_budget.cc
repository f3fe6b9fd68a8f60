// Memory for scenes as arithmetic: limits hold, short builds overtake long ones, and none waits for ever.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "service/daemon/scenes/memory_budget.h"

namespace omni::daemon {
namespace test_daemon_memory_budget {

using Answer = MemoryBudget::Answer;
using Number = MemoryBudget::Number;

scene::BuildNeed Need(std::uint64_t kept_MB, std::uint64_t peak_MB) { return {kept_MB * kMB, peak_MB * kMB}; }

BuildRequest Scene(std::uint64_t client, const scene::BuildNeed& need) {
  return {.job = client, .payer = client, .soft = false, .need = need};
}

const scene::BuildNeed kGiant = Need(250, 1170);

Number Started(MemoryBudget& budget, const BuildRequest& request) {
  const Number number = budget.Wait(request);
  EXPECT_EQ(budget.StartNext(), number);
  return number;
}

TEST(MemoryBudget, AGiantIsBuiltAloneWithSmallOnesBesideIt) {
  MemoryBudget budget({.builders = 4});
  Started(budget, Scene(1, kGiant));
  const Number second = budget.Wait(Scene(2, Need(300, 800)));
  const Number small = budget.Wait(Scene(3, Need(1, 20)));
  EXPECT_EQ(budget.StartNext(), small) << "it goes before the one that has to wait";
  EXPECT_EQ(budget.StartNext(), std::nullopt);
  EXPECT_EQ(budget.WhyItWaits(second), "waits for memory: needs 800 MB, 10 MB are free");
}

TEST(MemoryBudget, AsManyBuildersAsAllowedAndOneOfThemIsLeftToScenes) {
  MemoryBudget budget({.builders = 2});
  const BuildRequest soft{.job = 1, .payer = 1, .soft = true, .need = Need(20, 100)};
  Started(budget, soft);
  budget.Wait(soft);
  EXPECT_EQ(budget.StartNext(), std::nullopt);
  Started(budget, Scene(2, Need(1, 20)));
  const Number third = budget.Wait(Scene(3, Need(1, 20)));
  EXPECT_EQ(budget.StartNext(), std::nullopt);
  EXPECT_EQ(budget.WhyItWaits(third), "waits: 2 others are being built");
}

TEST(MemoryBudget, RefusesWhatAClientMayNotKeep) {
  MemoryBudget budget({});
  std::string why;
  const Number first = Started(budget, Scene(1, {}));
  ASSERT_EQ(budget.Grow(first, Need(200, 900), why), Answer::kGranted);
  budget.Finish(first, 190 * kMB);
  BuildRequest other = Scene(1, Need(100, 500));
  other.job = 77;  // of the same client
  EXPECT_EQ(budget.WhyRefused(other),
            "needs 100 MB, a client may have 256 MB of built scenes and has 190 MB of others; simplify the model, or "
            "tag only what is touched");
  EXPECT_EQ(budget.WhyRefused(Scene(1, Need(250, 900))), "") << "it replaces its own";
  EXPECT_EQ(budget.WhyRefused(Scene(2, Need(200, 500))), "");
  EXPECT_EQ(budget.WhyRefused(Scene(2, Need(200, 1300))),
            "needs 1300 MB while it is built, the limit is 1200 MB; simplify the model, or tag only what is touched");
}

TEST(MemoryBudget, WaitsUntilOthersGiveUpTheirScenes) {
  MemoryBudget budget({.builders = 4});
  const Number kept = budget.Finish(Started(budget, Scene(1, kGiant)), 250 * kMB);
  budget.Finish(Started(budget, Scene(4, kGiant)), 250 * kMB);
  budget.Finish(Started(budget, Scene(5, kGiant)), 250 * kMB);
  const Number second = budget.Wait(Scene(2, kGiant));
  EXPECT_EQ(budget.StartNext(), std::nullopt);
  EXPECT_EQ(budget.WhyItWaits(second), "waits for memory: needs 250 MB, 18 MB are free until other applications end");
  const Number third = budget.Wait(Scene(3, Need(10, 300)));
  EXPECT_EQ(budget.StartNext(), third);
  budget.FreeKept(kept);
  EXPECT_EQ(budget.StartNext(), std::nullopt) << "the pool is used";
  budget.End(third);
  EXPECT_EQ(budget.StartNext(), second);
}

// What is replaced stays for a while: memory as a whole keeps its limit.
TEST(MemoryBudget, AReplacedSceneCountsUntilItIsFreed) {
  MemoryBudget budget({.builders = 4});
  budget.Finish(Started(budget, Scene(2, kGiant)), 250 * kMB);
  budget.Finish(Started(budget, Scene(3, kGiant)), 250 * kMB);
  const Number old = budget.Finish(Started(budget, Scene(1, kGiant)), 250 * kMB);
  const Number again = Started(budget, Scene(1, kGiant));
  budget.Finish(again, 250 * kMB);
  EXPECT_EQ(budget.kept_bytes(), 1000 * kMB);
  budget.Wait(Scene(1, kGiant));
  EXPECT_EQ(budget.StartNext(), std::nullopt) << "232 MB are kept beyond the limit, the pool is smaller by them";
  budget.FreeKept(old);
  EXPECT_TRUE(budget.StartNext());
}

TEST(MemoryBudget, GoesBackToItsPlaceWhenThereIsNoRoom) {
  MemoryBudget budget({.builders = 4});
  const Number first = Started(budget, Scene(1, Need(1, 60))), second = Started(budget, Scene(2, Need(1, 20)));
  std::string why;
  EXPECT_EQ(budget.Grow(second, kGiant, why), Answer::kWaits);
  EXPECT_EQ(why, "waits for memory: needs 1170 MB, 1140 MB are free") << "the first one takes 60 MB";
  budget.Wait(Scene(3, Need(1, 1190)));
  budget.End(first);
  EXPECT_EQ(budget.StartNext(), second) << "the first to come";
}

struct Kept {
  Number number;
  int until;
};

// Random requests, answers and ends: no limit is ever exceeded, and whatever can run does in the end.
TEST(MemoryBudget, KeepsItsLimitsAndStarvesNone) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    const auto roll = [&](std::uint64_t low, std::uint64_t high) {
      return low + std::uint64_t{random()} % (high - low + 1);
    };
    const MemoryLimits limits{.builders = static_cast<std::uint32_t>(roll(2, 8))};
    MemoryBudget budget(limits);
    std::map<Number, BuildRequest> running;
    std::vector<Kept> kept;
    int asked = 0, ended = 0, refused = 0;
    for (int step = 0; step < 3000; ++step) {
      const bool more = step < 1500;
      if (more && roll(0, 2) == 0) {
        const bool giant = roll(0, 4) == 0;
        BuildRequest request =
            Scene(roll(1, 6), giant ? Need(roll(100, 250), roll(700, 1200)) : Need(roll(1, 5), roll(5, 90)));
        request.soft = roll(0, 5) == 0;
        if (budget.WhyRefused(request).empty()) {
          const Number number = budget.Wait(request);
          running[number] = request;
          ++asked;
        }
      }
      while (budget.StartNext()) {
      }
      ASSERT_LE(budget.running(), limits.builders);
      ASSERT_LE(budget.peak_bytes(), limits.pool_bytes) << "seed " << seed;
      ASSERT_LE(budget.kept_bytes() + budget.peak_bytes(), limits.kept_bytes + limits.pool_bytes) << "seed " << seed;
      // One that runs ends, or grows.
      std::vector<Number> now;
      for (const auto& [number, request] : running) {
        if (!budget.IsWaiting(number)) now.push_back(number);
      }
      if (!now.empty() && roll(0, 1) == 0) {
        const Number one = now[roll(0, now.size() - 1)];
        const BuildRequest request = running[one];
        std::string why;
        const std::uint64_t what = roll(0, 3);
        if (what == 0) {
          const Answer answer = budget.Grow(one, {request.need.kept_bytes * 11 / 10, request.need.peak_bytes}, why);
          if (answer == Answer::kRefused) {
            budget.End(one);
            running.erase(one);
            ++refused;
          }
          ASSERT_EQ(why.empty(), answer == Answer::kGranted);
        } else if (what == 1) {
          budget.End(one);
          running.erase(one);
          ++ended;
        } else {
          kept.push_back(
              {budget.Finish(one, request.need.kept_bytes * roll(5, 10) / 10), step + static_cast<int>(roll(1, 60))});
          running.erase(one);
          ++ended;
        }
      }
      for (auto it = kept.begin(); it != kept.end();) {
        if (it->until > step) {
          ++it;
          continue;
        }
        budget.FreeKept(it->number);
        it = kept.erase(it);
      }
    }
    EXPECT_EQ(ended + refused, asked) << "seed " << seed << ": all have run";
    EXPECT_EQ(budget.waiting() + budget.running(), 0U) << "seed " << seed;
    EXPECT_EQ(budget.kept_bytes(), 0U);
  }
}

std::string TextOf(const std::string& file) {
  std::ifstream stream(OMNI_SOURCE_DIR "/" + file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The numbers that people read are those that hold, and the unit has room for omnid itself.
TEST(MemoryBudget, DocumentsAndUnitHaveTheseLimits) {
  const MemoryLimits limits;
  const std::string document = TextOf("docs/scenes.md"), unit = TextOf("manifests/systemd/omnid.service.in");
  for (const auto& [what, bytes] :
       {std::pair("or soft in them | ", limits.client_bytes), std::pair("of all clients | ", limits.kept_bytes),
        std::pair("together | ", limits.pool_bytes)}) {
    EXPECT_NE(document.find(what + std::to_string(bytes / kMB) + " MB |"), std::string::npos) << what;
  }
  EXPECT_NE(document.find("at most " + std::to_string(MemoryBudget::kMostOvertaken) + " of them"), std::string::npos);
  EXPECT_NE(unit.find("\nMemoryMax=2G\n"), std::string::npos);
  EXPECT_NE(document.find("the 2 GiB that its unit allows"), std::string::npos);
  EXPECT_NE(unit.find("\nOOMPolicy=continue\n"), std::string::npos);
  constexpr std::uint64_t kService = 150 * kMB;
  EXPECT_LE(limits.kept_bytes + limits.pool_bytes + kService, std::uint64_t{2} << 30);
}

// A stream of small ones does not keep a giant waiting.
TEST(MemoryBudget, AGiantRunsAfterSoManyThatOvertookIt) {
  MemoryBudget budget({.builders = 8});
  std::vector<Number> small{Started(budget, Scene(1, Need(1, 100)))};
  const Number giant = budget.Wait(Scene(2, kGiant));
  std::uint32_t overtook = 0;
  for (std::uint64_t i = 0; i < 100 && budget.IsWaiting(giant); ++i) {
    budget.Wait(Scene(10 + i, Need(1, 100)));
    if (const auto started = budget.StartNext()) {
      small.push_back(*started);
      overtook += *started == giant ? 0 : 1;
    }
    budget.End(small.front());
    small.erase(small.begin());
    if (small.empty()) break;
  }
  while (budget.IsWaiting(giant)) {
    const auto started = budget.StartNext();
    ASSERT_TRUE(started);
    ASSERT_EQ(*started, giant);
  }
  EXPECT_LE(overtook, MemoryBudget::kMostOvertaken);
  EXPECT_GT(overtook, 2U);
}

}  // namespace test_daemon_memory_budget
}  // namespace omni::daemon
