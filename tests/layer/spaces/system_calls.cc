// xrLocateSpace of the pen: one runtime call, and no system call of ours.
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "service/base/sanitized.h"
#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_quiet {

using SpacesSystemCalls = SpacesTest;

TEST_F(SpacesSystemCalls, LocateSpaceMakesOneRuntimeCall) {
  App app;
  Start(app);
  const XrSpace view = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  service.Fill();
  const std::int64_t now = Now_ns();
  for (const auto& [space, base] : {std::pair(pen, local), {pen, view}, {view, pen}, {pen, pen}, {local, view}}) {
    const long before = omni_test_call_count("xrLocateSpace");
    ASSERT_EQ(Locate(space, base, now).result, XR_SUCCESS);
    EXPECT_EQ(omni_test_call_count("xrLocateSpace"), before + 1);
  }
}

// From here on any system call but exit_group kills this process with SIGSYS.
bool ForbidSystemCalls() {
  const sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
  };
  const sock_fprog program{static_cast<unsigned short>(std::size(filter)), const_cast<sock_filter*>(filter)};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

constexpr int kNoFilter = 99;

// How a child ended that runs `body` without system calls: its exit status, or 128 + signal.
template <class Body>
int WithoutSystemCalls(Body body) {
  const pid_t child = fork();
  if (child == 0) {
    if (!ForbidSystemCalls()) _exit(kNoFilter);
    _exit(body());
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// The same, tried again where a busy computer stops it for so long that the pen counts as gone.
template <class Body>
int WithFreshSamples(FakeService& service, Body body) {
  int status = 0;
  for (int i = 0; i < 20; ++i) {
    service.Fill();
    status = WithoutSystemCalls(body);
    if (status == 0 || status >= kNoFilter) break;
  }
  return status;
}

TEST_F(SpacesSystemCalls, LocateSpaceMakesNoSystemCall) {
  if (base::kSanitized) GTEST_SKIP() << "a sanitizer makes system calls of its own";
  App app;
  Start(app);
  const XrSpace view = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  service.Fill();
  const std::int64_t now = Now_ns();
  Locate(pen, view, now);  // lazy binding
  const int probe = WithoutSystemCalls([] { return static_cast<int>(syscall(SYS_getppid) == 0); });
  if (probe == kNoFilter) GTEST_SKIP() << "this kernel takes no seccomp filter";
  ASSERT_EQ(probe, 128 + SIGSYS) << "the probe itself must be able to fail";
  EXPECT_EQ(WithFreshSamples(service,
                             [&] {
                               for (std::int64_t t = now - 50'000'000; t < now + 50'000'000; t += 500'000) {
                                 if (Locate(pen, view, t).location.locationFlags != kSeen) return 1;
                                 if (Locate(view, pen, t).location.locationFlags != kSeen) return 2;
                                 if (Locate(pen, local, t).location.locationFlags != kSeen) return 3;
                               }
                               return 0;
                             }),
            0);
}

TEST_F(SpacesSystemCalls, LocateSpaceOfAMovingBaseMakesNoSystemCall) {
  if (base::kSanitized) GTEST_SKIP() << "a sanitizer makes system calls of its own";
  App app;
  Start(app, [](double /*t_s*/) { return layer::Motion{}; });
  service.MoveBase([](protocol::BaseSample& sample) { sample.linear_velocity_space_m_s = {0.5, 0, 0}; });
  ForgetOldPath(app);
  ForgetOldPath(app);
  service.Fill();
  const std::int64_t now = Now_ns();
  ASSERT_NEAR(Locate(pen, local, now - 20'000'000).v().x, 0.5, 1e-6) << "it follows the base";
  if (WithoutSystemCalls([] { return 0; }) == kNoFilter) GTEST_SKIP() << "this kernel takes no seccomp filter";
  EXPECT_EQ(WithFreshSamples(service,
                             [&] {
                               for (std::int64_t t = now - 50'000'000; t < now + 50'000'000; t += 500'000) {
                                 if ((Locate(pen, local, t).location.locationFlags & layer::kValid) != layer::kValid)
                                   return 1;
                                 if ((Locate(local, pen, t).location.locationFlags & layer::kValid) != layer::kValid)
                                   return 2;
                               }
                               return 0;
                             }),
            0);
}

}  // namespace test_spaces_quiet
}  // namespace omni::test
