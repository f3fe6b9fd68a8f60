// The loop that boards run, on a board in plain memory.
#include "firmware/core/run.h"

#include <gtest/gtest.h>

#include <deque>

#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_run {

struct MemoryBoard {
  void Read(Inputs& inputs) {
    order += 'r';
    inputs = plant.Step(outputs);
  }
  void Write(const Outputs& new_outputs) {
    order += 'w';
    outputs = new_outputs;
  }
  std::size_t Receive(std::uint8_t* frame, std::size_t capacity) {
    if (from_host.empty() || from_host.front().size() > capacity) return 0;
    const Bytes bytes = from_host.front();
    from_host.pop_front();
    std::copy(bytes.begin(), bytes.end(), frame);
    ++received;
    return bytes.size();
  }
  bool Send(const std::uint8_t* frame, std::size_t size) {
    order += 's';
    to_host.emplace_back(frame, frame + size);
    return true;
  }

  FirmwarePlant plant{Settings{}, {}};
  Outputs outputs;
  std::string order;
  std::deque<Bytes> from_host;
  std::vector<Bytes> to_host;
  int received = 0;
};

TEST(FirmwareRun, ReadsStepsWritesThenSends) {
  MemoryBoard board;
  FaultRecord record;
  Runner<MemoryBoard> runner(board, Settings{}, ResetCause::kPower, 1, record);
  for (int step = 0; step < 4; ++step) runner.Step();
  EXPECT_EQ(board.order, "rwrwrwrws");
  EXPECT_EQ(board.to_host.size(), 1U);
  for (int step = 0; step < 4000; ++step) runner.Step();
  EXPECT_EQ(runner.core().state(), wire::State::kIdle);
}

TEST(FirmwareRun, HandlesAtMostFourFramesPerStep) {
  MemoryBoard board;
  FaultRecord record;
  Runner<MemoryBoard> runner(board, Settings{}, ResetCause::kPower, 1, record);
  board.from_host.assign(100, Bytes(30, 0));
  runner.Step();
  EXPECT_EQ(board.received, 4);
  for (int step = 0; step < 24; ++step) runner.Step();
  EXPECT_EQ(board.received, 100);
}

}  // namespace test_firmware_run
}  // namespace omni::firmware
