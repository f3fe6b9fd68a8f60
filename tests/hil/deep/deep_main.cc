// omni_deep [options] -- EMULATOR ARGUMENTS: a simulated base on a USB port of an emulated computer. The emulator is
// started with two sockets: descriptor 3 is the port (QEMU: -chardev socket,fd=3 for its usb-redir), descriptor 4 a
// serial line on which the guest sends, one word per line, what a user would do with the cable: plug, unplug. Started
// by tests/hil/deep/run.
//
// The exit status is 0 if the guest passed its checks and the base's own counts agree.
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "firmware/core/link/settings.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/console/command.h"
#include "service/sim/twin/twin.h"
#include "tests/hil/chain.h"
#include "tests/hil/deep/redir_port.h"
#include "tests/hil/time/host_process.h"
#include "tests/hil/time/pacer.h"

namespace omni::hil {
namespace {

constexpr int kPortFd = 3, kOrdersFd = 4;
constexpr int kOwnFdMin = 10;     // ours, away from those
constexpr int kGuestPassed = 33;  // the guest wrote 16 to isa-debug-exit: 2 * 16 + 1
constexpr std::uint64_t kPlugs = 2;

// An emulated computer is many times slower than a real one. So is the base's clock, and it stands still while the
// guest is behind: the test checks that the guest's USB works, not how fast.
constexpr std::int64_t kSlower = 4;

struct DeepOptions {
  std::string board = "qemu";
  sim::PlantOptions plant;
  double seconds = 180;  // longer means that the guest hangs
  std::vector<std::string> emulator;
};

int Fail(const std::string& message) {
  std::fprintf(stderr, "omni_deep: %s\n", message.c_str());
  return 1;
}

// A pair of sockets: one end under the number that the emulator expects, the other, which is not blocking, is returned.
base::UniqueFd SocketTo(int emulator_fd) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return {};
  base::UniqueFd ours(fcntl(ends[0], F_DUPFD_CLOEXEC, kOwnFdMin));
  const base::UniqueFd theirs(fcntl(ends[1], F_DUPFD_CLOEXEC, kOwnFdMin));
  close(ends[0]);
  close(ends[1]);
  if (!ours || !theirs || fcntl(ours.get(), F_SETFL, O_NONBLOCK) != 0 || dup2(theirs.get(), emulator_fd) < 0) return {};
  return ours;
}

// The guest's orders for the cable.
class Orders {
 public:
  Orders(base::UniqueFd line, RedirPort& port) : line_(std::move(line)), port_(port) {}

  // An error: an unknown order.
  base::Status Serve() {
    char text[256];
    const ssize_t size = recv(line_.get(), text, sizeof text, 0);
    for (ssize_t i = 0; i < size; ++i) {
      if (text[i] == '\r') continue;
      if (text[i] != '\n') {
        word_ += text[i];
        continue;
      }
      if (base::Status obeyed = Obey(std::exchange(word_, {})); !obeyed) return obeyed;
    }
    return base::Ok{};
  }

 private:
  base::Status Obey(const std::string& word) {
    if (word == "plug") {
      port_.Plug();
    } else if (word == "unplug") {
      port_.Unplug();
    } else {
      return base::Error{"the guest orders \"" + word + "\"; known are plug and unplug"};
    }
    return base::Ok{};
  }

  base::UniqueFd line_;
  RedirPort& port_;
  std::string word_;
};

class Checks {
 public:
  void Add(bool holds, const std::string& what) {
    std::printf("%-4s  outside: %s\n", holds ? "ok" : "FAIL", what.c_str());
    passed_ = passed_ && holds;
  }
  bool passed() const { return passed_; }

 private:
  bool passed_ = true;
};

bool Judge(int emulator_status, const Chain& chain, const RedirPort& port) {
  const RedirCounts& usb = port.counts();
  const wire::Telemetry& last = chain.telemetry();
  const auto text = [](std::uint64_t number) { return std::to_string(number); };
  std::printf("base: %s ms of its time, %s frames fetched, %s sent to it, %s requests, %s of them refused\n",
              text(chain.counts().steps / firmware::kStepsPerTick).c_str(), text(usb.frames_in).c_str(),
              text(usb.frames_out).c_str(), text(usb.requests).c_str(), text(usb.stalls).c_str());
  Checks checks;
  checks.Add(emulator_status == kGuestPassed, "the guest passed its checks (status " + std::to_string(emulator_status) +
                                                  ", " + std::to_string(kGuestPassed) + " wanted)");
  checks.Add(usb.plugged == kPlugs && usb.aborted > 0, "plugged " + text(usb.plugged) + " times, " + text(usb.aborted) +
                                                           " transfers in flight when the cable was pulled");
  checks.Add(usb.refused == 0, text(usb.refused) + " messages that a base has no use for");
  checks.Add(chain.counts().commands > 0 && last.rejected == 0,
             text(chain.counts().commands) + " commands, " + text(last.rejected) + " frames rejected by the core");
  checks.Add(last.state == wire::State::kFault && (last.faults & wire::kFaultEmergencyStop) != 0,
             "the base ended in its emergency stop");
  return checks.passed();
}

base::Result<bool> RunDeep(const DeepOptions& options) {
  base::UniqueFd port_socket = SocketTo(kPortFd);
  base::UniqueFd orders_line = SocketTo(kOrdersFd);
  if (!port_socket || !orders_line) return base::Error{"no descriptors left for two sockets"};
  auto emulator = HostProcess::Start(options.emulator, {});
  close(kPortFd);  // before the board, which may be an emulator too
  close(kOrdersFd);
  if (!emulator) return base::Error{emulator.error()};
  auto board = MakeBoard(options.board);
  if (!board) return base::Error{board.error()};
  sim::Plant plant(config::DefaultDevice(), options.plant);
  Chain chain(plant, **board);
  RedirPort port(std::move(port_socket), chain, firmware::Settings{}.serial);
  Orders orders(std::move(orders_line), port);
  port.Plug();
  Pacer pacer;
  const std::int64_t end_ns = base::MonotonicNow_ns() + static_cast<std::int64_t>(options.seconds * 1e9);
  while (!emulator->Ended()) {
    if (base::MonotonicNow_ns() > end_ns) return base::Error{"the guest did not finish in time"};
    pacer.Wait(kSlower * base::kTickPeriod_ns);
    port.Serve();
    if (base::Status obeyed = orders.Serve(); !obeyed) return base::Error{obeyed.error()};
    if (port.HostIsBehind()) continue;
    for (int i = 0; i < firmware::kStepsPerTick; ++i) {
      if (base::Status stepped = chain.Step(); !stepped) return base::Error{stepped.error()};
    }
    port.Serve();
  }
  return Judge(*emulator->Ended(), chain, port);
}

int ParseAndRun(const std::vector<std::string>& own, std::vector<std::string> emulator) {
  DeepOptions options;
  options.emulator = std::move(emulator);
  options.plant.truth = config::IdealTwin();
  std::string script;
  console::Program app("omni_deep", "omni_deep: a simulated base on a USB port of an emulated computer");
  app.Add("--board", options.board, "where the control core runs").OneOf({"host", "qemu"}).ShowDefault();
  app.Add("--script", script, "hand script (.json); default: no pen");
  app.Add("--seconds", options.seconds, "the guest may take").ShowDefault();
  if (const auto ended = app.Parse(own)) return *ended;
  if (!script.empty()) {
    auto loaded = sim::LoadHandScript(script);
    if (!loaded) return Fail(loaded.error());
    options.plant.script = *loaded;
  }
  const base::Result<bool> passed = RunDeep(options);
  if (!passed) return Fail(passed.error());
  return *passed ? 0 : 1;
}

}  // namespace
}  // namespace omni::hil

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  std::vector<std::string> own, emulator;
  bool ours = true;
  for (int i = 1; i < argc; ++i) {
    if (ours && std::string(argv[i]) == "--") {
      ours = false;
    } else {
      (ours ? own : emulator).emplace_back(argv[i]);
    }
  }
  try {
    return omni::hil::ParseAndRun(own, emulator);
  } catch (const std::exception& error) {
    return omni::hil::Fail(error.what());
  }
}
