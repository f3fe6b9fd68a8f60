// The emulated board as a device: it starts, answers, ends, and survives invalid requests; its host reports why it
// ended and leaves no process behind.
#include "tests/hil/board/qemu_board.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include "firmware/board/mps2_an500/host_link.h"
#include "tests/hil/board/tools.h"

namespace omni::hil {
namespace {

using namespace firmware;

std::unique_ptr<QemuBoard> StartBoard(const QemuBoard::Options& options = {}) {
  auto board = QemuBoard::Start(options);
  EXPECT_TRUE(board.ok()) << (board.ok() ? "" : board.error());
  return board.ok() ? std::move(*board) : nullptr;
}

bool IsSafe(const Outputs& outputs) {
  return outputs.duty[0] == 0 && outputs.duty[1] == 0 && outputs.duty[2] == 0 && outputs.awake == 0;
}

TEST(QemuBoard, AnswersStepsAndExitsWithTheRequestedStatus) {
  OMNI_NEEDS_BOARD();
  const auto board = StartBoard();
  ASSERT_NE(board, nullptr);
  LockstepRequest request;
  for (int i = 0; i < 8; ++i) {
    request.inputs.now_us += kStepPeriod_us;
    const auto answer = board->Step(request);
    ASSERT_TRUE(answer.ok()) << answer.error();
  }
  const auto end = board->Exit(42);
  ASSERT_TRUE(end.ok()) << end.error();
  EXPECT_EQ(end->status, 42);
  EXPECT_GT(end->report.at("stack_bytes"), 100U);
  EXPECT_EQ(end->report.at("refused"), 0U);
  EXPECT_FALSE(board->Step(request).ok());
}

// Requests of random bytes: unknown operations are refused and counted, steps with random inputs and frames are for the
// core to refuse. The board goes on.
TEST(QemuBoard, SurvivesRandomRequests) {
  OMNI_NEEDS_BOARD();
  const auto board = StartBoard();
  ASSERT_NE(board, nullptr);
  std::mt19937_64 random(4);
  std::uint32_t refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::uint64_t words[sizeof(LockstepRequest) / 8];
    for (std::uint64_t& word : words) word = random();
    LockstepRequest request;
    std::memcpy(static_cast<void*>(&request), words, sizeof request);
    if (i % 3 == 0) request.op = LockstepOp::kStep;
    if (i % 3 == 1) request.op = LockstepOp::kReset;  // for an unknown cause
    if (request.op == LockstepOp::kExit) continue;
    const auto answer = board->Step(request);
    ASSERT_TRUE(answer.ok()) << answer.error();
    if (request.op == LockstepOp::kStep) continue;
    ++refused;
    EXPECT_TRUE(IsSafe(answer->outputs));
  }
  ASSERT_TRUE(board->Reset(ResetCause::kSoftware).ok());
  ASSERT_TRUE(board->Step(LockstepRequest{}).ok());
  LockstepRequest unknown;
  unknown.op = static_cast<LockstepOp>(77);
  ASSERT_TRUE(board->Step(unknown).ok());
  const auto end = board->Exit(0);
  ASSERT_TRUE(end.ok()) << end.error();
  EXPECT_EQ(end->report.at("refused"), 1U) << "a reset clears the count";
  EXPECT_GE(refused, 1900U);
}

TEST(QemuBoard, KilledBoardReportsItsExitStatus) {
  OMNI_NEEDS_BOARD();
  const auto board = StartBoard();
  ASSERT_NE(board, nullptr);
  ASSERT_TRUE(board->Step(LockstepRequest{}).ok());
  kill(board->pid(), SIGKILL);
  const auto answer = board->Step(LockstepRequest{});
  ASSERT_FALSE(answer.ok());
  EXPECT_NE(answer.error().find("has ended (exit status 137)"), std::string::npos) << answer.error();
  EXPECT_FALSE(board->Exit(0).ok());
}

TEST(QemuBoard, StoppedBoardTimesOut) {
  OMNI_NEEDS_BOARD();
  QemuBoard::Options options;
  options.timeout_ms = 5000;
  auto board = StartBoard(options);
  ASSERT_NE(board, nullptr);
  ASSERT_TRUE(board->Step(LockstepRequest{}).ok());
  kill(board->pid(), SIGSTOP);
  siginfo_t stopped{};  // all its threads: until then it may still answer
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(board->pid()), &stopped, WSTOPPED | WNOWAIT), 0);
  const auto begin = std::chrono::steady_clock::now();
  const auto answer = board->Step(LockstepRequest{});
  const auto waited = std::chrono::steady_clock::now() - begin;
  ASSERT_FALSE(answer.ok());
  EXPECT_NE(answer.error().find("no answer within 5000 ms"), std::string::npos) << answer.error();
  EXPECT_GE(waited, std::chrono::milliseconds(4900));
}

TEST(LockstepImage, ExitsWhenTheHostClosesTheLink) {
  OMNI_NEEDS_BOARD();
  const test::TempFolder folder;
  const std::string to = folder.Path(board::kToBoard), from = folder.Path(board::kFromBoard);
  ASSERT_EQ(mkfifo(to.c_str(), 0600), 0);
  ASSERT_EQ(mkfifo(from.c_str(), 0600), 0);
  const int from_board = open(from.c_str(), O_RDONLY | O_NONBLOCK);
  const auto process = QemuProcess::Start({"mps2_lockstep", {}}, folder.Path());
  ASSERT_TRUE(process.ok()) << process.error();
  const int to_board = open(to.c_str(), O_WRONLY);
  ASSERT_EQ(write(to_board, "half a request", 14), 14);
  close(to_board);
  EXPECT_EQ((*process)->Wait(20'000), board::kExitLinkLost) << (*process)->output();
  close(from_board);
}

TEST(LockstepImage, ReportsMissingFifosAndBadArguments) {
  OMNI_NEEDS_BOARD();
  auto run = RunImage({"mps2_lockstep", {}}, 20'000);
  ASSERT_TRUE(run.ok()) << run.error();
  EXPECT_EQ(run->status, board::kExitNoLink);
  EXPECT_NE(run->output.find("to_board"), std::string::npos) << run->output;
  run = RunImage({"mps2_lockstep", {"backwards"}}, 20'000);
  ASSERT_TRUE(run.ok()) << run.error();
  EXPECT_EQ(run->status, board::kExitUsage);
  EXPECT_NE(run->output.find("the only argument"), std::string::npos) << run->output;
}

TEST(QemuProcess, MissingImageIsAnError) {
  OMNI_NEEDS_BOARD();
  const auto run = RunImage({"no_such_image", {}}, 1000);
  ASSERT_FALSE(run.ok());
  EXPECT_NE(run.error().find("no_such_image.elf is missing"), std::string::npos) << run.error();
}

// Gone, or a zombie.
bool HasEnded(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string number, name, state;
  return !(file >> number >> name >> state) || state == "Z" || state == "X";
}

TEST(QemuProcess, DiesWithTheTestThatStartedIt) {
  OMNI_NEEDS_BOARD();
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t tester = fork();
  if (tester == 0) {
    auto board = QemuBoard::Start({});
    const pid_t pid = board.ok() && (*board)->Step(LockstepRequest{}).ok() ? (*board)->pid() : -1;
    const bool reported = write(pipe_ends[1], &pid, sizeof pid) == sizeof pid;
    if (reported) pause();
    _exit(1);
  }
  pid_t qemu = -1;
  ASSERT_EQ(read(pipe_ends[0], &qemu, sizeof qemu), static_cast<ssize_t>(sizeof qemu));
  ASSERT_GT(qemu, 0);
  EXPECT_FALSE(HasEnded(qemu));
  kill(tester, SIGKILL);
  waitpid(tester, nullptr, 0);
  bool ended = false;
  for (int i = 0; i < 100 && !ended; ++i) {
    ended = HasEnded(qemu);
    if (!ended) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_TRUE(ended) << "QEMU " << qemu << " has outlived its test";
  close(pipe_ends[0]);
  close(pipe_ends[1]);
}

}  // namespace
}  // namespace omni::hil
