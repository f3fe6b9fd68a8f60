// A computer that does not keep up is named, and no longer when it does.
#include "service/daemon/devices/host_watch.h"

#include <gtest/gtest.h>

namespace omni::daemon {
namespace test_daemon_host_watch {

struct Seconds {
  HostWatch watch;
  std::uint64_t ticks = 0, late = 0, superseded = 0;
  std::int64_t now_ns = 1;

  // So many seconds with a thousand ticks each; returns how often the verdict changed.
  int Pass(int seconds, std::uint64_t late_each, std::uint64_t superseded_each, std::uint64_t ticks_each = 1000) {
    int changed = 0;
    for (int s = 0; s < seconds; ++s) {
      changed += watch.Update(ticks, late, superseded, now_ns) ? 1 : 0;
      ticks += ticks_each, late += late_each, superseded += superseded_each;
      now_ns += 1'000'000'000;
    }
    return changed;
  }
};

TEST(HostWatch, NamesALateHostAndLetsGo) {
  Seconds s;
  EXPECT_EQ(s.Pass(20, 1, 1), 0);  // .2 %
  EXPECT_EQ(s.Pass(4, 30, 0), 0) << "a stall of some seconds";
  EXPECT_EQ(s.Pass(20, 0, 0), 0);
  EXPECT_EQ(s.Pass(20, 6, 6), 1) << "1.2 % of both together";
  EXPECT_TRUE(s.watch.starved());
  EXPECT_EQ(s.Pass(20, 3, 3), 0) << "between the two limits nothing changes";
  EXPECT_EQ(s.Pass(20, 0, 1), 1);
  EXPECT_FALSE(s.watch.starved());
}

TEST(HostWatch, FewTicksSayNothing) {
  Seconds s;
  EXPECT_EQ(s.Pass(60, 20, 0, 30), 0);
  EXPECT_FALSE(s.watch.starved());
}

}  // namespace test_daemon_host_watch
}  // namespace omni::daemon
