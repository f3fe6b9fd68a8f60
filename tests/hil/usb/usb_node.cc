#include "tests/hil/usb/usb_node.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace omni::hil {
namespace {

constexpr int kFifoSize = 4096;  // one page, the least: a pipe is writable as soon as a page is free

}  // namespace

base::Result<UsbNode> UsbNode::Make(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  if (mkfifo(path.c_str(), 0666) != 0) return base::Error{path + ": " + std::strerror(errno)};
  base::UniqueFd fd(open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!fd) return base::Error{path + ": " + std::strerror(errno)};
  if (fcntl(fd.get(), F_SETPIPE_SZ, kFifoSize) != kFifoSize) return base::Error{path + ": cannot be made small"};
  UsbNode node(std::move(fd));
  node.SetReady(false);
  return node;
}

// The client never reads or writes the node itself: the content is ours.
void UsbNode::SetReady(bool ready) {
  if (ready == ready_) return;
  ready_ = ready;
  std::array<char, kFifoSize> page{};
  const ssize_t moved = ready ? read(fd_.get(), page.data(), page.size()) : write(fd_.get(), page.data(), page.size());
  if (moved != kFifoSize) std::abort();  // this class is the only user of the FIFO
}

}  // namespace omni::hil
