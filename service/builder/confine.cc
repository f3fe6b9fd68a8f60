#include "service/builder/confine.h"

#include <fcntl.h>
#include <linux/seccomp.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "service/base/sanitized.h"

namespace omni::builder {
namespace {

constexpr int kNice = 5;

// Whatever their arguments. Reading and writing is of what is open; memory is bounded by RLIMIT_AS.
constexpr int kAllowed[] = {
    SCMP_SYS(read),
    SCMP_SYS(pread64),
    SCMP_SYS(pwrite64),
    SCMP_SYS(sendmsg),
    SCMP_SYS(recvmsg),
    SCMP_SYS(poll),
    SCMP_SYS(ppoll),
    SCMP_SYS(close),
    SCMP_SYS(fstat),
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(madvise),
    SCMP_SYS(brk),
    SCMP_SYS(futex),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(getrandom),
    SCMP_SYS(getpid),
    SCMP_SYS(gettid),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(sched_yield),
    SCMP_SYS(restart_syscall),
};

using Filter = std::unique_ptr<void, void (*)(scmp_filter_ctx)>;

base::Error Failed(const char* step, int error) {
  return base::Error{std::string("cannot confine itself: ") + step + ": " + std::strerror(error)};
}

bool Allow(const Filter& filter, int call, std::initializer_list<scmp_arg_cmp> arguments = {}) {
  return seccomp_rule_add_array(filter.get(), SCMP_ACT_ALLOW, call, static_cast<unsigned>(arguments.size()),
                                arguments.begin()) == 0;
}

bool AddRules(const Filter& filter) {
  for (const int call : kAllowed) {
    if (!Allow(filter, call)) return false;
  }
  constexpr scmp_datum_t kNoCode = 0;
  const auto no_code = [](unsigned argument) { return scmp_arg_cmp{argument, SCMP_CMP_MASKED_EQ, PROT_EXEC, kNoCode}; };
  const auto own = static_cast<scmp_datum_t>(getpid());
  return Allow(filter, SCMP_SYS(mmap), {no_code(2)}) && Allow(filter, SCMP_SYS(mprotect), {no_code(2)}) &&
         // A copy of a descriptor; and what the C library's fstat is: the path, which is not seen here, can only serve
         // to learn a file's size.
         Allow(filter, SCMP_SYS(fcntl), {scmp_arg_cmp{1, SCMP_CMP_EQ, F_DUPFD_CLOEXEC, 0}}) &&
         Allow(filter, SCMP_SYS(newfstatat), {scmp_arg_cmp{3, SCMP_CMP_MASKED_EQ, AT_EMPTY_PATH, AT_EMPTY_PATH}}) &&
         // abort()
         Allow(filter, SCMP_SYS(tgkill),
               {scmp_arg_cmp{0, SCMP_CMP_EQ, own, 0}, scmp_arg_cmp{2, SCMP_CMP_EQ, SIGABRT, 0}}) &&
         Allow(filter, SCMP_SYS(rt_sigaction), {scmp_arg_cmp{0, SCMP_CMP_EQ, SIGABRT, 0}});
}

}  // namespace

base::Status Retire() {
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return Failed("PR_SET_PDEATHSIG", errno);
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return Failed("PR_SET_NO_NEW_PRIVS", errno);
  const rlimit none{0, 0};
  if (setrlimit(RLIMIT_CORE, &none) != 0) return Failed("RLIMIT_CORE", errno);
  if (setpriority(PRIO_PROCESS, 0, kNice) != 0) return Failed("setpriority", errno);
  const int file = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  const bool written = file >= 0 && write(file, "1000", 4) == 4;
  const int error = errno;
  if (file >= 0) close(file);
  return written ? base::Status(base::Ok{}) : Failed("/proc/self/oom_score_adj", error);
}

base::Status ConfineItself() {
  if (base::kSanitized) return base::Ok{};
  const Filter filter(seccomp_init(SCMP_ACT_KILL_PROCESS), [](scmp_filter_ctx made) { seccomp_release(made); });
  if (filter == nullptr) return Failed("seccomp_init", ENOMEM);
  if (!AddRules(filter)) return Failed("a rule of seccomp", EINVAL);
  const int error = -seccomp_load(filter.get());
  return error == 0 ? base::Status(base::Ok{}) : Failed("seccomp_load", error);
}

}  // namespace omni::builder
