// A program in the place of omni-builder that says what it should not is refused in words, and leaves nothing behind;
// and what a real one may not do ends it.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fcntl.h>

#include <filesystem>
#include <string>

#include "service/base/sanitized.h"
#include "service/builder/confine.h"
#include "service/daemon/scenes/child_builder.h"
#include "service/daemon/scenes/scene_builder.h"
#include "tests/builder/scene_builder_test.h"

namespace omni::daemon {
namespace test_builder_hostile {

namespace fs = std::filesystem;

struct Hostile {
  const char* what;
  const char* words;  // of the error
};
constexpr Hostile kHostile[] = {
    {"leaves", "ended without a result (exit status 7)"},
    {"closes", "closed its connection"},
    // A sanitizer catches the signal, reports it, and ends the program itself.
    {"crashes", base::kSanitized ? "ended without a result (exit status " : "crashed (Segmentation fault)"},
    {"short-message", "of a wrong length"},
    {"long-message", "too long"},
    {"unknown-kind", "broke its protocol"},
    {"descriptor", "or a descriptor"},
    {"huge-need", "the limit is 1200 MB"},
    {"keeps-much", "a client may have 256 MB of built scenes"},
    {"need-twice", "broke its protocol"},
    {"digest-first", "broke its protocol"},
    {"result-first", "broke its protocol"},
    {"file-elsewhere", "it was not opened"},
    {"many-files", "broke its protocol"},
    {"too-many-bytes", "broke its protocol"},
    {"truncated-block", "the builder's result "},
    {"no-bytes", "broke its protocol"},
    {"grows-memory", "it did not grow"},
};

class HostileBuilder : public SceneBuilderTest {
 protected:
  // The program is what its name says.
  std::shared_ptr<const BuildWay> Way(const std::string& what) const {
    std::error_code there;
    fs::create_symlink(OMNI_BINARY_DIR "/tests/omni_hostile_builder", folder_.Path(what), there);
    return std::make_shared<const ChildBuilder>(folder_.Path(what));
  }
  std::string ErrorOf(const std::string& what) const {
    SceneBuilder builder({.way = Way(what)});
    builder.Request(1, app_);
    std::optional<BuiltScene> built;
    EXPECT_TRUE(Soon([&] { return (built = builder.PopResult()).has_value(); })) << what;
    if (!built) return {};
    EXPECT_EQ(built->scene, nullptr) << what;
    EXPECT_TRUE(Soon([&] { return builder.Status().rows.empty(); }));
    EXPECT_EQ(builder.Status().kept_bytes + builder.Status().peak_bytes, 0U);
    return built->error;
  }

  const config::AppEntry app_ = Rigid("ball");
};

TEST_F(HostileBuilder, IsRefusedInWordsAndLeavesNothing) {
  const std::size_t files = OpenFiles();
  for (const Hostile& row : kHostile) {
    const std::string error = ErrorOf(row.what);
    EXPECT_NE(error.find(row.words), std::string::npos) << row.what << ": " << error;
    EXPECT_TRUE(Soon([&] { return OpenFiles() == files; })) << row.what;
  }
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "no process is left";
  const std::string control = ErrorOf("control-characters");
  EXPECT_EQ(control.find('\x1b'), std::string::npos) << "nothing for terminals";
}

TEST_F(HostileBuilder, OneThatNeverAnswersIsCancelled) {
  const std::size_t files = OpenFiles();
  {
    SceneBuilder builder({.way = Way("silent")});
    builder.Request(1, app_);
    EXPECT_TRUE(Soon([&] { return builder.Status().peak_bytes > 0; }));
    builder.Cancel(1);
    EXPECT_TRUE(Soon([&] { return builder.Status().rows.empty(); }));
    EXPECT_FALSE(builder.PopResult());
  }
  EXPECT_TRUE(Soon([&] { return OpenFiles() == files; }));
}

// How a process ended that is confined and then does something.
int Confined(const std::function<void()>& act) {
  const pid_t child = fork();
  if (child == 0) {
    if (!builder::Retire().ok() || !builder::ConfineItself().ok()) _exit(99);
    act();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

TEST(Confined, MayBuildAndNothingElse) {
  if (base::kSanitized) GTEST_SKIP() << "sanitizers make system calls of their own";
  EXPECT_EQ(Confined([] {
              std::vector<double> memory(10'000'000, 1.5);
              memory.resize(20'000'000);
              char byte = 0;
              if (pread(0, &byte, 1, 0) > 1) _exit(9);
            }),
            0);
  const pid_t self = getpid();
  struct Forbidden {
    const char* what;
    std::function<void()> act;
  };
  const Forbidden all[] = {
      {"open a file", [] { static_cast<void>(open("/etc/passwd", O_RDONLY)); }},
      {"make a file", [] { static_cast<void>(open("/tmp/omni-builder-test", O_RDWR | O_CREAT, 0600)); }},
      {"make a socket", [] { static_cast<void>(socket(AF_INET, SOCK_STREAM, 0)); }},
      {"connect", [] { static_cast<void>(connect(0, nullptr, 0)); }},
      {"start a program", [] { execl("/bin/true", "true", nullptr); }},
      {"fork", [] { static_cast<void>(fork()); }},
      {"kill another process", [self] { kill(self, 0); }},
      {"make memory files", [] { static_cast<void>(memfd_create("x", 0)); }},
      {"write to standard error",
       [] {
         if (write(2, "x", 1) < 0) _exit(9);
       }},
      {"turn memory into code",
       [] { static_cast<void>(mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)); }},
      {"raise its limits",
       [] {
         if (nice(-1) == -1) _exit(9);
       }},
  };
  for (const Forbidden& row : all) EXPECT_EQ(Confined(row.act), -SIGSYS) << row.what;
}

}  // namespace test_builder_hostile
}  // namespace omni::daemon
