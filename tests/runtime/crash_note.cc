#include "tests/runtime/crash_note.h"

#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <signal.h>
#include <ucontext.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace omni::runtime {
namespace {

constexpr int kSignals[] = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};
constexpr uintptr_t kFirstPage = 4096;
char crash_file[4096];

// Null: the address belongs to no shared object.
const char* ObjectOf(const void* address) {
  Dl_info info{};
  return dladdr(address, &info) != 0 ? info.dli_fname : nullptr;
}

// abort() and what it is made of are in the C library, and ThreadSanitizer's stands before it; whoever called it is
// meant.
bool StandsBehindAbort(const char* object) {
  return std::strstr(object, "/libc.so") != nullptr || std::strstr(object, "/libtsan.so") != nullptr;
}

const char* Culprit(const ucontext_t& context) {
  const auto address = static_cast<uintptr_t>(context.uc_mcontext.gregs[REG_RIP]);
  if (address < kFirstPage) return "nowhere";
  const auto* const instruction = reinterpret_cast<const void*>(address);
  const char* const object = ObjectOf(instruction);
  if (object == nullptr) return "generated code";
  if (!StandsBehindAbort(object)) return object;
  void* frames[64];
  const int count = backtrace(frames, 64);
  bool below = false;  // the crash, not this handler
  for (int i = 0; i < count; ++i) {
    below = below || frames[i] == instruction;
    const char* const caller = ObjectOf(frames[i]);
    if (below && caller != nullptr && !StandsBehindAbort(caller)) return caller;
  }
  return object;
}

void OnCrash(int signal, siginfo_t*, void* context) {
  const char* const culprit = Culprit(*static_cast<const ucontext_t*>(context));
  const int file = open(crash_file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const bool written = file >= 0 && write(file, culprit, std::strlen(culprit)) >= 0 && write(file, "\n", 1) == 1;
  if (!written) std::perror(crash_file);
  // The handler is used once: this one has the default effect, as soon as it returns.
  raise(signal);
}

}  // namespace

void NoteCrashes() {
  const char* const file = std::getenv("OMNI_TEST_RUNTIME_CRASH");
  if (file == nullptr || *file == '\0') return;
  std::snprintf(crash_file, sizeof(crash_file), "%s", file);
  void* unused[1];
  backtrace(unused, 1);  // its first call allocates
  struct sigaction action {};
  action.sa_sigaction = &OnCrash;
  action.sa_flags = SA_SIGINFO | static_cast<int>(SA_RESETHAND);
  for (const int signal : kSignals) sigaction(signal, &action, nullptr);
}

}  // namespace omni::runtime
