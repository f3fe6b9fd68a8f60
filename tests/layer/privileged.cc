// The layer in a program that has more rights than whoever started it (set-uid, set-gid): whoever started it has chosen
// the environment, and must not write files or choose a service with the program's rights.
#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/process/temp_folder.h"

namespace omni::test {
namespace test_privileged {

constexpr uid_t kNobody = 65534;
constexpr const char* kChosenLine = "\nroot::0:0::/:/bin/sh\n";

std::string Content(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// For root: set-uid, started by another user. For others: set-gid, if they are in a second group.
bool GiveMoreRights(const std::string& program) {
  if (::geteuid() == 0) return ::chmod(program.c_str(), 04755) == 0;
  std::array<gid_t, 64> groups{};
  const int count = ::getgroups(static_cast<int>(groups.size()), groups.data());
  for (int i = 0; i < count; ++i) {
    const gid_t group = groups[static_cast<std::size_t>(i)];
    if (group != ::getegid() && ::chown(program.c_str(), static_cast<uid_t>(-1), group) == 0)
      return ::chmod(program.c_str(), 02755) == 0;
  }
  return false;
}

void BecomeNobody() {
  const bool done = ::setgroups(0, nullptr) == 0 && ::setresgid(kNobody, kNobody, kNobody) == 0 &&
                    ::setresuid(kNobody, kNobody, kNobody) == 0;
  if (!done) ::_exit(3);
}

class Privileged : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(::chmod(temp.Path().c_str(), 0755), 0);
    std::filesystem::copy_file(OMNI_BINARY_DIR "/tests/layer_privileged_app", program);
    ASSERT_EQ(::chmod(program.c_str(), 0755), 0);
  }

  // Starts the program with a log of the caller's choice and a line for it. Returns its output; "": it failed.
  std::string Run(const std::string& log, bool by_nobody) const {
    int ends[2];
    if (::pipe(ends) != 0) return {};
    const pid_t child = ::fork();
    if (child == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      ::setenv("OMNI_LAYER_LOG", log.c_str(), 1);
      ::setenv("OMNI_HAND", kChosenLine, 1);
      if (by_nobody) BecomeNobody();
      ::execl(program.c_str(), program.c_str(), nullptr);
      ::_exit(2);
    }
    ::close(ends[1]);
    std::string printed;
    char part[256];
    for (ssize_t size = 0; (size = ::read(ends[0], part, sizeof(part))) > 0;)
      printed.append(part, static_cast<std::size_t>(size));
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? printed : std::string();
  }

  const TempFolder temp;
  const std::string program = temp.Path("app");
};

TEST_F(Privileged, UnprivilegedProgramWritesLog) {
  const std::string log = temp.Path("log");
  EXPECT_EQ(Run(log, false), "not secure\n");
  EXPECT_NE(Content(log).find("OMNI_HAND=?root::0:0::/:/bin/sh? is neither left nor right"), std::string::npos)
      << Content(log);
}

TEST_F(Privileged, PrivilegedProgramIgnoresCallersLogPath) {
  if (!GiveMoreRights(program)) GTEST_SKIP() << "this user is in one group only: no set-gid program can be made";
  const std::string file = temp.Write("secret", "before\n");
  ASSERT_EQ(::chmod(file.c_str(), 0600), 0);
  const std::string printed = Run(file, ::geteuid() == 0);
  if (printed == "not secure\n") GTEST_SKIP() << temp.Path() << " lies on a file system without set-uid";
  EXPECT_EQ(printed, "secure\n");
  EXPECT_EQ(Content(file), "before\n");
  Run(temp.Path("new"), ::geteuid() == 0);
  EXPECT_FALSE(std::filesystem::exists(temp.Path("new")));
}

}  // namespace test_privileged
}  // namespace omni::test
