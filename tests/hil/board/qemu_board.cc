#include "tests/hil/board/qemu_board.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cstring>
#include <fstream>

#include "firmware/board/mps2_an500/host_link.h"

namespace omni::hil {
namespace {

using base::Error;
using base::Ok;
using base::Result;
using base::Status;
using namespace firmware;

static_assert(std::endian::native == std::endian::little, "requests travel as they stand in memory");

}  // namespace

Result<std::unique_ptr<QemuBoard>> QemuBoard::Start(const Options& options) {
  std::unique_ptr<QemuBoard> made(new QemuBoard(options));
  if (const Status opened = made->Open(); !opened) return Error{opened.error()};
  QemuProcess::Options process;
  process.image = "mps2_lockstep";
  process.count_instructions = options.count_instructions;
  if (options.count_instructions) process.arguments = {board::kCount};
  auto started = QemuProcess::Start(process, made->folder_.Path());
  if (!started) return Error{started.error()};
  made->process_ = std::move(*started);
  return made;
}

QemuBoard::~QemuBoard() {
  if (process_ != nullptr) process_->Kill();
  if (to_board_ >= 0) ::close(to_board_);
  if (from_board_ >= 0) ::close(from_board_);
}

// Our ends are open before the board starts, so neither side waits for the other. Opening our writing end for reading
// too avoids SIGPIPE from a dead board; its end is detected when its answer is read.
Status QemuBoard::Open() {
  const std::string to = folder_.Path(board::kToBoard), from = folder_.Path(board::kFromBoard);
  if (::mkfifo(to.c_str(), 0600) != 0 || ::mkfifo(from.c_str(), 0600) != 0) {
    return Error{"cannot make FIFOs in " + folder_.Path() + ": " + std::strerror(errno)};
  }
  to_board_ = ::open(to.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  from_board_ = ::open(from.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (to_board_ < 0 || from_board_ < 0)
    return Error{"cannot open " + to + " and " + from + ": " + std::strerror(errno)};
  return Ok{};
}

Result<LockstepAnswer> QemuBoard::Step(const LockstepRequest& request) {
  if (request.op == LockstepOp::kExit) return Error{"kExit has no answer: use Exit"};
  if (const Status sent = SendRaw(&request, sizeof request); !sent) return Error{sent.error()};
  LockstepAnswer answer;
  if (const Status received = Receive(&answer, sizeof answer); !received) return Error{received.error()};
  return answer;
}

Status QemuBoard::Reset(ResetCause cause) {
  LockstepRequest request;
  request.op = LockstepOp::kReset;
  request.argument = static_cast<std::uint32_t>(cause);
  const auto answer = Step(request);
  if (!answer) return Error{answer.error()};
  return Ok{};
}

Result<QemuBoard::End> QemuBoard::Exit(int status) {
  LockstepRequest request;
  request.op = LockstepOp::kExit;
  request.argument = static_cast<std::uint32_t>(status);
  if (const Status sent = SendRaw(&request, sizeof request); !sent) return Error{sent.error()};
  const std::optional<int> ended = process_->Wait(options_.timeout_ms);
  if (!ended) return Lost("does not end");
  lost_ = "the board has ended";
  End end;
  end.status = *ended;
  std::ifstream report(folder_.Path(board::kReport));
  std::string name;
  std::uint32_t number = 0;
  while (report >> name >> number) end.report[name] = number;
  return end;
}

Status QemuBoard::SendRaw(const void* data, std::size_t size) {
  if (!lost_.empty()) return Error{lost_};
  const auto* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(to_board_, at, size);
    if (written > 0) {
      at += written;
      size -= static_cast<std::size_t>(written);
      continue;
    }
    if (written < 0 && errno == EINTR) continue;
    pollfd room{to_board_, POLLOUT, 0};
    if (errno != EAGAIN || ::poll(&room, 1, options_.timeout_ms) == 0) return Lost("takes no request");
  }
  return Ok{};
}

Status QemuBoard::Receive(void* data, std::size_t size) {
  auto* at = static_cast<char*>(data);
  while (size > 0) {
    // A board that ended before it opened its FIFO is detected only by its process.
    pollfd answer_or_end[] = {{from_board_, POLLIN, 0}, {process_->pidfd(), POLLIN, 0}};
    const int ready = ::poll(answer_or_end, 2, options_.timeout_ms);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return Lost("gives no answer within " + std::to_string(options_.timeout_ms) + " ms");
    if (answer_or_end[0].revents == 0) return Lost("has ended");
    const ssize_t count = ::read(from_board_, at, size);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count <= 0) return Lost("has ended");
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return Ok{};
}

// Ends what is left of it.
Error QemuBoard::Lost(const std::string& what) {
  const std::optional<int> status = process_->Wait(what == "has ended" ? 1000 : 0);
  lost_ = "the emulated board " + what + (status ? " (exit status " + std::to_string(*status) + ")" : "");
  if (const std::string output = process_->output(); !output.empty()) lost_ += ": " + output;
  process_->Kill();
  return Error{lost_};
}

}  // namespace omni::hil
