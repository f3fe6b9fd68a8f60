// The writer of all files that a user would miss: whichever system call fails or is the last, the path has the complete
// old or new content.
#include "service/base/files/whole_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "tests/support/process/temp_folder.h"
#include "tests/support/process/traced_child.h"

namespace omni::base {
namespace test_base_whole_file {

namespace fs = std::filesystem;
using test::Fate;
using test::RunTraced;
using test::SystemCall;
using test::TempFolder;

const std::string kOld(5'000, 'o'), kNew(100'000, 'n');

std::string ContentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t FilesIn(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

mode_t ModeOf(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
}

bool IsOneOf(std::uint64_t number, std::initializer_list<long> calls) {
  return std::find(calls.begin(), calls.end(), static_cast<long>(number)) != calls.end();
}

bool TouchesFiles(const SystemCall& call) {
  return IsOneOf(call.number,
                 {SYS_open, SYS_openat, SYS_write, SYS_fchmod, SYS_fsync, SYS_rename, SYS_renameat, SYS_renameat2,
                  SYS_link, SYS_unlink, SYS_stat, SYS_lstat, SYS_newfstatat, SYS_close, SYS_getrandom, SYS_mkdir});
}

// Runs `body` as a process of its own; what it returned.
int InChild(const std::function<int()>& body) {
  const pid_t pid = fork();
  if (pid == 0) _exit(body());
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

class WholeFileTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(folder_.Path("d"));
    path_ = folder_.Path("d/settings.toml");
  }
  // Replaces the old content with the new one in a traced child.
  int Put(const std::function<Fate(const SystemCall&)>& decide) {
    folder_.Write("d/settings.toml", kOld);
    return RunTraced([this] { return PutWholeFile(path_, {kNew}); }, decide);
  }
  bool IsOldOrNew() const {
    const std::string content = ContentOf(path_);
    return content == kOld || content == kNew;
  }
  void Clear() {
    for (const auto& entry : fs::directory_iterator(folder_.Path("d"))) fs::remove(entry.path());
  }

  const TempFolder folder_;
  std::string path_;
};

TEST_F(WholeFileTest, ReplacesContentAndLeavesNoTemporaryFile) {
  ASSERT_EQ(PutWholeFile(path_, {"one ", "and ", "two"}), 0);
  EXPECT_EQ(ContentOf(path_), "one and two");
  ASSERT_EQ(PutWholeFile(path_, {kNew}), 0);
  EXPECT_EQ(ContentOf(path_), kNew);
  ASSERT_EQ(PutWholeFile(path_, {}), 0);
  EXPECT_EQ(ContentOf(path_), "");
  EXPECT_EQ(FilesIn(folder_.Path("d")), 1U);
}

// Protects against power cuts: content before name, name before success.
TEST_F(WholeFileTest, SyncsFileBeforeAndFolderAfterRename) {
  std::vector<std::uint64_t> order;
  const int result = Put([&](const SystemCall& call) {
    if (IsOneOf(call.number, {SYS_write, SYS_fsync, SYS_rename, SYS_renameat, SYS_renameat2})) {
      order.push_back(call.number == SYS_write || call.number == SYS_fsync ? call.number : SYS_rename);
    }
    return Fate{};
  });
  if (result == test::kNoTrace) GTEST_SKIP() << "ptrace is not permitted here";
  ASSERT_EQ(result, 0);
  EXPECT_EQ(order, (std::vector<std::uint64_t>{SYS_write, SYS_fsync, SYS_rename, SYS_fsync}));
}

TEST_F(WholeFileTest, HasOldOrNewContentWhenKilledAtAnySystemCall) {
  int killed = 0, old = 0;
  for (int last = 0;; ++last) {
    int count = 0;
    const int result = Put([&](const SystemCall&) { return Fate{.dies = count++ == last}; });
    if (result == test::kNoTrace) GTEST_SKIP() << "ptrace is not permitted here";
    ASSERT_TRUE(IsOldOrNew()) << "killed before system call " << last;
    EXPECT_LE(FilesIn(folder_.Path("d")), 2U);
    if (result == 0) break;
    ASSERT_EQ(result, test::kKilled);
    ++killed;
    old += ContentOf(path_) == kOld ? 1 : 0;
    Clear();
  }
  EXPECT_GT(old, 5);
  EXPECT_GT(killed, old) << "some came after the step";
  std::printf("[ figure   ] killed at %d system calls: %d times the old file, %d times the new one, never another\n",
              killed, old, killed - old);
}

TEST_F(WholeFileTest, KeepsOldFileWhenAnySystemCallFails) {
  int failures = 0;
  std::set<int> errors;
  for (const int error : {ENOSPC, EDQUOT, EROFS, EACCES, EIO}) {
    for (int failing = 0;; ++failing) {
      int count = 0;
      std::uint64_t failed = 0;
      const int result = Put([&](const SystemCall& call) {
        if (!TouchesFiles(call) || count++ != failing) return Fate{};
        failed = call.number;
        return Fate{.error = error};
      });
      if (result == test::kNoTrace) GTEST_SKIP() << "ptrace is not permitted here";
      SCOPED_TRACE("system call " + std::to_string(failed) + " failed with " + std::to_string(error));
      ASSERT_GE(result, 0);
      EXPECT_EQ(ContentOf(path_), result == 0 ? kNew : kOld);
      EXPECT_EQ(FilesIn(folder_.Path("d")), 1U);
      if (result != 0) {
        EXPECT_EQ(result, error);
        ++failures;
        errors.insert(result);
      }
      Clear();
      if (count <= failing) break;  // there was none left to fail
    }
  }
  EXPECT_EQ(errors.size(), 5U);
  EXPECT_GE(failures, 20) << "opening, writing, syncing and the step, with each error";
}

TEST_F(WholeFileTest, KeepsOldFileWhenSizeLimitIsExceeded) {
  folder_.Write("d/settings.toml", kOld);
  const int result = InChild([this] {
    const rlimit small{.rlim_cur = 64'000, .rlim_max = 64'000};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    return PutWholeFile(path_, {kNew});
  });
  EXPECT_EQ(result, EFBIG);
  EXPECT_EQ(ContentOf(path_), kOld);
  EXPECT_EQ(FilesIn(folder_.Path("d")), 1U);
}

// A file system of 64 kB, first full, then read-only. What the child returns: errno, or one of these.
constexpr int kNoMount = 250, kNotOld = 251, kUnfinishedLeft = 252;

TEST_F(WholeFileTest, DistinguishesFullAndReadOnlyDisk) {
  const std::string disk = folder_.Path("d");
  const auto on_small_disk = [&](bool read_only) {
    return InChild([&, read_only] {
      const bool alone = unshare(CLONE_NEWNS) == 0 || unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0;
      if (!alone || mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return kNoMount;
      if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=64k") != 0) return kNoMount;
      if (PutWholeFile(path_, {kOld}) != 0) return kNotOld;
      if (read_only && mount(nullptr, disk.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) != 0) return kNoMount;
      const int error = PutWholeFile(path_, {kNew});
      if (ContentOf(path_) != kOld) return kNotOld;
      return FilesIn(disk) == 1 ? error : kUnfinishedLeft;
    });
  };
  const int full = on_small_disk(false), read_only = on_small_disk(true);
  if (full == kNoMount || read_only == kNoMount) GTEST_SKIP() << "no file system can be mounted here";
  EXPECT_EQ(full, ENOSPC);
  EXPECT_EQ(read_only, EROFS);
}

TEST_F(WholeFileTest, ReportsMissingFolderPermission) {
  folder_.Write("d/settings.toml", kOld);
  fs::permissions(folder_.Path("d"), fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_exec);
  fs::permissions(folder_.Path(), fs::perms::owner_all | fs::perms::others_exec);
  const int result = InChild([this] {
    if (::geteuid() == 0 && ::setresuid(65534, 65534, 65534) != 0) return 0;
    return PutWholeFile(path_, {kNew});
  });
  fs::permissions(folder_.Path("d"), fs::perms::owner_all);
  EXPECT_EQ(result, EACCES);
  EXPECT_EQ(ContentOf(path_), kOld);
}

TEST_F(WholeFileTest, EveryCauseHasItsOwnWordsAndRemedy) {
  std::set<std::string> texts;
  const std::pair<int, const char*> causes[] = {{ENOSPC, "no space left on its disk; free some"},
                                                {EDQUOT, "quota"},
                                                {EROFS, "read-only file system; mount"},
                                                {EACCES, "no permission; make the folder /a/b writable"},
                                                {EPERM, "no permission"},
                                                {ENOENT, "there is no folder /a/b; create it"},
                                                {EISDIR, "is a folder; name a file"},
                                                {EFBIG, "ulimit -f"},
                                                {EIO, "check the disk"}};
  for (const auto& [error, words] : causes) {
    const std::string text = WriteProblem("/a/b/c.toml", error);
    EXPECT_EQ(text.rfind("/a/b/c.toml: cannot be written: ", 0), 0U) << text;
    EXPECT_NE(text.find(words), std::string::npos) << text;
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), std::size(causes) - 1) << "EACCES and EPERM are the same to a person";
}

TEST_F(WholeFileTest, KeepsTheModeOfWhatItReplaces) {
  ASSERT_EQ(PutWholeFile(path_, {"x"}), 0);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  EXPECT_EQ(ModeOf(path_), 0666 & ~mask);
  ASSERT_EQ(::chmod(path_.c_str(), 0600), 0);
  ASSERT_EQ(PutWholeFile(path_, {"y"}), 0);
  EXPECT_EQ(ModeOf(path_), 0600U);
  ASSERT_EQ(PutWholeFile(path_, {"z"}, {.mode = 0640}), 0);
  EXPECT_EQ(ModeOf(path_), 0640U);
}

TEST_F(WholeFileTest, ReplacesSymlinkWithoutWritingItsTarget) {
  const std::string victim = folder_.Write("victim", "precious");
  for (const std::string& target : {victim, std::string("nowhere")}) {
    fs::remove(path_);
    ASSERT_EQ(::symlink(target.c_str(), path_.c_str()), 0);
    EXPECT_EQ(PutWholeFile(path_, {"x"}, {.replace = false}), EEXIST);
    ASSERT_EQ(PutWholeFile(path_, {"x"}), 0);
    EXPECT_FALSE(fs::is_symlink(path_));
    EXPECT_EQ(ContentOf(path_), "x");
  }
  EXPECT_EQ(ContentOf(victim), "precious");
}

// Run as root, `-o /dev/null` would otherwise turn that into a file.
TEST_F(WholeFileTest, RefusesToReplaceNonRegularFiles) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  EXPECT_EQ(PutWholeFile(path_, {"x"}), EINVAL);
  fs::remove(path_);
  ASSERT_EQ(::symlink("/dev/null", path_.c_str()), 0);
  EXPECT_EQ(PutWholeFile(path_, {"x"}), EINVAL);
  EXPECT_TRUE(fs::is_symlink(path_));
  EXPECT_EQ(PutWholeFile(folder_.Path("d"), {"x"}), EISDIR);
  EXPECT_EQ(FilesIn(folder_.Path("d")), 1U);
}

TEST_F(WholeFileTest, DoesNotReplaceWithoutOption) {
  ASSERT_EQ(PutWholeFile(path_, {kOld}, {.replace = false}), 0);
  EXPECT_EQ(PutWholeFile(path_, {kNew}, {.replace = false}), EEXIST);
  EXPECT_EQ(ContentOf(path_), kOld);
  EXPECT_EQ(FilesIn(folder_.Path("d")), 1U);
}

TEST_F(WholeFileTest, MakesFoldersOnlyWhenAsked) {
  const std::string deep = folder_.Path("d/a/b/c.toml");
  EXPECT_EQ(PutWholeFile(deep, {"x"}), ENOENT);
  ASSERT_EQ(PutWholeFile(deep, {"x"}, {.make_folder = true}), 0);
  EXPECT_EQ(ContentOf(deep), "x");
  EXPECT_EQ(PutWholeFile(deep + "/d.toml", {"x"}, {.make_folder = true}), ENOTDIR);
}

TEST_F(WholeFileTest, TryWholeFileLeavesNoFile) {
  EXPECT_EQ(TryWholeFile(path_), 0);
  EXPECT_EQ(FilesIn(folder_.Path("d")), 0U);
  folder_.Write("d/settings.toml", kOld);
  EXPECT_EQ(TryWholeFile(path_, {.replace = false}), EEXIST);
  EXPECT_EQ(TryWholeFile(path_), 0);
  EXPECT_EQ(ContentOf(path_), kOld);
  EXPECT_EQ(TryWholeFile(folder_.Path("no/such/file")), ENOENT);
}

}  // namespace test_base_whole_file
}  // namespace omni::base
