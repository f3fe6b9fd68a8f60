// In the place of omni-builder, says what it should not: what, is the name of the program it was started as. Its
// socket is descriptor 3, as omni-builder's.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "service/builder/messages.h"
#include "service/protocol/packet_socket.h"

namespace {

using namespace omni::builder;  // NOLINT(google-build-using-namespace): all of it is this protocol

template <class M>
void Say(const M& message, const std::string& text = {}, std::vector<int> fds = {}) {
  std::string bytes(reinterpret_cast<const char*>(&message), sizeof message);
  bytes += text;
  while (omni::protocol::SendPacket(kSocket, bytes.data(), bytes.size(), fds.data(), fds.size()) ==
         omni::protocol::SendResult::kFull) {
    usleep(1000);
  }
}

// A message of omnid, with its first descriptor.
int Hear() {
  std::vector<char> bytes(kMaxMessage);
  omni::base::UniqueFd fds[2];
  for (;;) {
    pollfd wait{kSocket, POLLIN, 0};
    poll(&wait, 1, -1);
    const auto received = omni::protocol::ReceivePacket(kSocket, bytes.data(), bytes.size(), fds, 2);
    if (received.result == omni::protocol::ReceiveResult::kPacket) return fds[0].Release();
    if (received.result != omni::protocol::ReceiveResult::kNothing) _exit(1);
  }
}

Need Plausible() { return {.kept_bytes = 1'000'000, .peak_bytes = 20'000'000}; }

// As far as the result: its memory.
int ToResult() {
  Say(Plausible());
  const int memory = Hear();
  Say(Digest{});
  Hear();
  return memory;
}

void Claim(std::uint64_t bytes, const std::string& text = {}, Outcome outcome = Outcome::kBuilt) {
  Finished finished;
  finished.outcome = outcome;
  finished.bytes = bytes;
  finished.text_bytes = static_cast<std::uint32_t>(text.size());
  Say(finished, text);
}

void Act(const std::string& what) {
  Hear();  // the job
  if (what == "silent") pause();
  if (what == "leaves") _exit(7);
  if (what == "closes") close(kSocket), pause();
  if (what == "crashes") raise(SIGSEGV);
  if (what == "short-message") Say(std::uint8_t{1});
  if (what == "long-message") Say(Plausible(), std::string(60'000, 'x'));
  if (what == "unknown-kind") Say(std::uint32_t{99}, std::string(200, 'x'));
  if (what == "descriptor") Say(Plausible(), {}, {0, 1, 2});
  if (what == "huge-need") Say(Need{.kept_bytes = UINT64_MAX, .peak_bytes = UINT64_MAX});
  if (what == "keeps-much") Say(Need{.kept_bytes = 1ull << 40, .peak_bytes = 1});
  if (what == "need-twice") Say(Plausible()), Hear(), Say(Plausible());
  if (what == "digest-first") Say(Digest{});
  if (what == "result-first") Claim(100);
  if (what == "file-elsewhere") {
    const std::string name = "../../../../../../etc/passwd";
    Say(Open{.text_bytes = static_cast<std::uint32_t>(name.size())}, name);
    // What it was given goes into the error that omnid says.
    const int file = Hear();
    Claim(0, file >= 0 ? "it was opened" : "it was not opened", Outcome::kRefused);
  }
  if (what == "many-files") {
    for (;;) {
      Say(Open{.text_bytes = 1}, "x");
      close(Hear());
    }
  }
  if (what == "too-many-bytes") ToResult(), Claim(UINT64_MAX);
  if (what == "truncated-block") {
    const int memory = ToResult();
    const std::string junk(1000, 'j');
    if (pwrite(memory, junk.data(), junk.size(), 0) < 0) _exit(9);
    Claim(junk.size());
  }
  if (what == "no-bytes") ToResult(), Claim(0);
  if (what == "grows-memory") {
    const int memory = ToResult();
    const bool grown =
        ftruncate(memory, 1L << 40) == 0 || ftruncate(memory, 0) == 0 || fcntl(memory, F_ADD_SEALS, F_SEAL_WRITE) == 0;
    Claim(0, grown ? "it grew" : "it did not grow", Outcome::kRefused);
  }
  if (what == "control-characters") Claim(0, "\x1b[2J\x1b]0;owned\a", Outcome::kRefused);
  pause();
}

}  // namespace

int main(int, char** argv) { Act(std::filesystem::path(argv[0]).filename().string()); }
