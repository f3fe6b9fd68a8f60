// Unmodified programs under a virtual clock: their waits end at its time, however long that is, and it does not advance
// while they are busy.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "service/base/clock.h"
#include "service/base/sanitized.h"
#include "tests/hil/time/host_process.h"
#include "tests/hil/time/idle_watch.h"
#include "tests/hil/time/virtual_clock.h"
#include "tests/support/process/temp_folder.h"

namespace omni::hil {
namespace {

constexpr std::int64_t kStep_ns = 10'000'000;
constexpr std::int64_t kPatience_us = 100'000'000;  // on a busy machine half a second of work takes many
const std::string kProbe = std::string(OMNI_BINARY_DIR) + "/tests/hil_clock_probe";

class VirtualClockTest : public testing::Test {
 protected:
  void SetUp() override {
    if (base::kSanitized) GTEST_SKIP() << "a sanitizer wants to be the first library of a program, and the clock is";
    const base::Status possible = IdleWatch::Possible();
    if (!possible) GTEST_SKIP() << possible.error();
    auto made = VirtualClock::Create(folder_.Path("clock"));
    ASSERT_TRUE(made.ok()) << made.error();
    clock_.emplace(std::move(*made));
  }

  HostProcess Start(const std::string& way) {
    auto started = HostProcess::Start({kProbe, way, folder_.Path("out")}, clock_->Environment());
    if (!started.ok()) std::abort();
    EXPECT_TRUE(clock_->WaitForProcess(started->pid(), 10'000)) << "the probe did not come";
    return std::move(*started);
  }

  // The probe with another page, or none.
  base::Result<HostProcess> StartElsewhere(const std::string& way, const std::string& page) {
    std::vector<std::string> environment = clock_->Environment();
    environment.front() = std::string(kClockVariable) + "=" + page;
    return HostProcess::Start({kProbe, way, folder_.Path("out")}, environment);
  }

  // One step of the clock and its consequences. False: a thread is still busy.
  bool Step() {
    clock_->AdvanceTo(clock_->now_ns() + kStep_ns);
    return quiet_.Wait(clock_->Processes(), kPatience_us);
  }

  // What it wrote: milliseconds and a number. -1: nothing.
  std::pair<double, int> Outcome() const {
    std::ifstream file(folder_.Path("out"));
    std::pair<double, int> outcome{-1, 0};
    file >> outcome.first >> outcome.second;
    return outcome;
  }

  const test::TempFolder folder_;
  std::optional<VirtualClock> clock_;
  IdleWatch quiet_;
};

struct Way {
  const char* name;
  int result;
};
void PrintTo(const Way& way, std::ostream* out) { *out << way.name; }

class VirtualWait : public VirtualClockTest, public testing::WithParamInterface<Way> {};

TEST_P(VirtualWait, LastsTenVirtualSeconds) {
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  HostProcess probe = Start(GetParam().name);
  ASSERT_TRUE(quiet_.Wait(clock_->Processes(), kPatience_us)) << quiet_.busy();
  int steps = 0;
  while (!probe.Ended() && steps < 2000) {
    ASSERT_TRUE(Step()) << quiet_.busy() << " is permanently busy";
    ++steps;
  }
  EXPECT_EQ(probe.Kill(), 0);
  const auto [took_ms, result] = Outcome();
  EXPECT_DOUBLE_EQ(took_ms, 10'000);
  EXPECT_EQ(result, GetParam().result);
  EXPECT_LE(steps, 1001);
  std::printf("%s: 10 s in %.2f s\n", GetParam().name, static_cast<double>(base::MonotonicNow_ns() - begin_ns) * 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Every, VirtualWait,
                         testing::Values(Way{"sleep", 0}, Way{"sleep_until", 0}, Way{"poll", 0}, Way{"poll_data", 1},
                                         Way{"epoll", 0}, Way{"signal", -1}, Way{"timerfd", 9}),
                         [](const auto& way) { return std::string(way.param.name); });

// Its short real waits may end after the instant: it may be late, never early.
TEST_F(VirtualClockTest, ConditionVariableNeverTimesOutEarly) {
  HostProcess probe = Start("condition");
  while (!probe.Ended() && clock_->now_ns() - clock_->zero_ns() < 100'000'000'000) {
    ASSERT_TRUE(Step());
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  EXPECT_EQ(probe.Kill(), 0);
  EXPECT_GE(Outcome().first, 10'000);
  EXPECT_EQ(Outcome().second, 0);
}

TEST_F(VirtualClockTest, ComputationTakesNoVirtualTime) {
  HostProcess probe = Start("work");
  EXPECT_FALSE(quiet_.Wait(clock_->Processes(), 20'000)) << "half a second of work was not detected";
  EXPECT_NE(quiet_.busy().find("hil_clock_probe"), std::string::npos) << quiet_.busy();
  ASSERT_TRUE(quiet_.Wait(clock_->Processes(), kPatience_us));
  EXPECT_EQ(Outcome().first, 0);
}

TEST_F(VirtualClockTest, StoppedProgramDoesNotHoldUpTheClock) {
  HostProcess probe = Start("sleep");
  ASSERT_TRUE(quiet_.Wait(clock_->Processes(), kPatience_us));
  probe.Signal(SIGSTOP);
  for (int i = 0; i < 1200; ++i) ASSERT_TRUE(Step());
  EXPECT_FALSE(probe.Ended());
  probe.Signal(SIGCONT);
  ASSERT_TRUE(quiet_.Wait(clock_->Processes(), kPatience_us));
  EXPECT_DOUBLE_EQ(Outcome().first, 12'000) << "it was stopped for two seconds more";
}

TEST_F(VirtualClockTest, KilledProgramIsRemoved) {
  HostProcess probe = Start("sleep");
  EXPECT_EQ(clock_->Processes().size(), 1U);
  probe.Kill();
  EXPECT_TRUE(clock_->Processes().empty());
  EXPECT_TRUE(Step());
}

TEST_F(VirtualClockTest, ProgramsExitWhenTheMasterIsGone) {
  HostProcess probe = Start("sleep");
  const pid_t nobody = fork();
  if (nobody == 0) _exit(0);
  waitpid(nobody, nullptr, 0);
  const int fd = open(folder_.Path("clock").c_str(), O_RDWR);
  void* const memory = mmap(nullptr, sizeof(ClockPage), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  ASSERT_NE(memory, MAP_FAILED);
  static_cast<ClockPage*>(memory)->master_pid.store(nobody);
  munmap(memory, sizeof(ClockPage));
  for (int i = 0; i < 100 && !probe.Ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_TRUE(probe.Ended());
  EXPECT_EQ(probe.Kill(), 70);
}

TEST_F(VirtualClockTest, MissingProgramNeverJoins) {
  auto started = HostProcess::Start({"/nonexistent/program"}, clock_->Environment());
  ASSERT_TRUE(started.ok());
  EXPECT_FALSE(clock_->WaitForProcess(started->pid(), 10'000));
}

TEST_F(VirtualClockTest, RejectsAnInvalidClockPage) {
  const std::string path = folder_.Write("wrong", std::string(sizeof(ClockPage), 'x'));
  auto started = StartElsewhere("sleep", path);
  ASSERT_TRUE(started.ok());
  for (int i = 0; i < 100 && !started->Ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(started->Ended(), 127);
}

// omni_virtual_time, which advances to the first timer by itself.
class VirtualTime : public VirtualClockTest {
 protected:
  static std::optional<int> Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(OMNI_BINARY_DIR) + "/tests/omni_virtual_time");
    auto started = HostProcess::Start(arguments, {});
    for (int i = 0; i < 600 && !started->Ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return started->Ended();
  }
};

TEST_F(VirtualTime, TenSecondWaitsEndOnTimeWithoutRealWaiting) {
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  int waits = 0;
  for (const Way& way : {Way{"sleep", 0}, Way{"sleep_until", 0}, Way{"poll", 0}, Way{"poll_data", 1}, Way{"epoll", 0},
                         Way{"signal", -1}, Way{"timerfd", 9}, Way{"condition", 0}, Way{"fork", 7}}) {
    ASSERT_EQ(Run({kProbe, way.name, folder_.Path("out")}), 0) << way.name;
    EXPECT_DOUBLE_EQ(Outcome().first, 10'000) << way.name;
    EXPECT_EQ(Outcome().second, way.result) << way.name;
    ++waits;
  }
  EXPECT_LT(base::MonotonicNow_ns() - begin_ns, waits * 5'000'000'000) << "half of what they waited for";
}

TEST_F(VirtualTime, ExitStatusIsThatOfTheProgram) {
  EXPECT_EQ(Run({kProbe, "work", folder_.Path("out")}), 0);
  EXPECT_EQ(Outcome().first, 0) << "work takes no time";
  EXPECT_EQ(Run({kProbe, "no such way"}), 2);
  EXPECT_EQ(Run({"sh", "-c", "kill -9 $$"}), 128 + SIGKILL);
  EXPECT_EQ(Run({"/nonexistent/program"}), 127);
  EXPECT_EQ(Run({}), 127);
}

TEST_F(VirtualTime, DescendantsShareTheVirtualTime) {
  const std::string out = folder_.Path("out");
  ASSERT_EQ(Run({"sh", "-c", kProbe + " sleep " + out + " & wait"}), 0);
  EXPECT_DOUBLE_EQ(Outcome().first, 10'000);
}

TEST_F(VirtualClockTest, TimeIsRealWithoutAClockPage) {
  auto started = StartElsewhere("work", "");
  ASSERT_TRUE(started.ok());
  for (int i = 0; i < 200 && !started->Ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(started->Kill(), 0);
  // Not 500: a hypervisor's count of processor time may run ahead of the clock by a few parts in a thousand.
  EXPECT_GE(Outcome().first, 450) << "half a second of processor time is about that of the clock";
}

}  // namespace
}  // namespace omni::hil
